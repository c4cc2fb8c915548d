#pragma once
// The acts, each made for one skeleton. A family is a file of this folder.
#include "simulator/people/act.h"

namespace rotunda::simulator::acts {

using MakeMotion = Motion(const Skeleton&, const MotionOptions&);

MakeMotion idle, hands_on_hips, a_pose;               // standing.cpp
MakeMotion walk, jog;                                 // going.cpp
MakeMotion idle_walk, walk_idle, walk_jog, jog_walk;  // changing_gait.cpp
MakeMotion kick, turn;                                // kick.cpp
MakeMotion capoeira;                                  // capoeira.cpp
MakeMotion dance;                                     // dance.cpp
MakeMotion board;                                     // board.cpp

}  // namespace rotunda::simulator::acts
