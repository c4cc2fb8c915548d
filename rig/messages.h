#pragma once
// Between the API's messages and the plain structs that clients and daemon work with. Private to rig/.
#include "rig/client.h"
#include "rig/motion_frame.h"
#include "rig/rotunda.grpc.pb.h"

namespace rotunda::rig {

TakeProgress from_message(const v1::TakeProgress& message);
RigStatus from_message(const v1::Status& message);
TakeRequest from_message(const v1::StartTakeRequest& message);
v1::TakeProgress to_message(const TakeProgress& progress);
v1::Status to_message(const RigStatus& status);
PlateReport from_message(const v1::PlateReport& message);
v1::PlateReport to_message(const PlateReport& report);
TakeAnnotation from_message(const v1::AnnotateTakeRequest& message);
v1::AnnotateTakeRequest to_message(const TakeAnnotation& annotation);
v1::StartTakeRequest to_message(const TakeRequest& request);
IdentifyRequest from_message(const v1::IdentifyRequest& message);
v1::IdentifyRequest to_message(const IdentifyRequest& request);
LivePacket from_message(const v1::LivePacket& message);
v1::LivePacket to_message(const LivePacket& packet);
// Throws InvalidInput where a frame is not whole, or its body is none.
MotionFrame from_message(const v1::MotionFrame& message);
v1::MotionFrame to_message(const MotionFrame& frame);
std::vector<IdentifiedCamera> from_message(const v1::IdentifyAnswer& message);
v1::IdentifyAnswer to_message(const std::vector<IdentifiedCamera>& cameras);

}  // namespace rotunda::rig
