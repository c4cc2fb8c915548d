#pragma once
// How much of a camera's stream may be asked for again. A few lost packets are worth asking for; a link that loses many
// only loses more when they are sent again, those of the cameras beside it too. Pure.
#include <cstdint>

namespace rotunda::capture {

class ResendBudget {
 public:
  // `share` of the packets, 0 to 1.
  explicit ResendBudget(double share) : budget_(share) {}

  // Packets that were due and packets asked for again, both since the stream began. False: too many since the last
  // verdict, ask for none until the next look. Fewer than a thousand are no measure: then the answer is true.
  bool look(std::uint64_t packets, std::uint64_t asked_again);
  double share() const { return share_; }  // asked for again at the last verdict

 private:
  double budget_;
  double share_ = 0.0;
  std::uint64_t packets_ = 0, asked_again_ = 0;
};

}  // namespace rotunda::capture
