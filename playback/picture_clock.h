#pragma once
// When a window draws its next picture, and how fine. Sixty pictures a second at most; where drawing takes longer than
// a film's frame, surfaces are drawn a level coarser, and finer again once there is time.
#include <chrono>
#include <string>

namespace rotunda::playback {

// Decides from how long pictures take. Seconds.
class DetailKeeper {
 public:
  // `deadline` for a picture; `coarsest`: so many levels below the finest at most.
  explicit DetailKeeper(double deadline = 1.0 / 25.0, int coarsest = 2) : deadline_(deadline), coarsest_(coarsest) {}
  void hear(double seconds);                // that a picture took
  int coarser() const { return coarser_; }  // levels below the finest

 private:
  void judge();

  const double deadline_;
  const int coarsest_;
  int coarser_ = 0;
  double sum_ = 0.0, quick_ = 0.0;             // of pictures since last judged; how long they have been quick
  int heard_ = 0, late_ = 0, quick_ones_ = 0;  // pictures since last judged
  double patience_ = 3.0;                      // how long they must be quick before a finer level is tried
  double since_finer_ = 1e9;                   // a finer level that does not keep the deadline makes for more patience
};

class PictureClock {
 public:
  PictureClock();
  double begin();  // of a picture: seconds since the last began
  // It is on the screen: sleeps until the next is due. What it took counts if coarser levels would have helped.
  void end(bool levels_matter = true);
  int coarser() const { return detail_.coarser(); }
  double seconds() const;  // since the clock was made
  // "58 pictures/s", and what was given up for it.
  std::string told() const;

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point made_, begun_;
  double period_ = 1.0 / 60.0;  // of pictures, evened out
  DetailKeeper detail_;
};

}  // namespace rotunda::playback
