#pragma once
// What a check of machine or rig found, in words, with the cure. Of this the doctor's table and the status are made.
#include <string>

namespace rotunda::rig {

// note: costs something only in some uses; look: costs frames or takes that are of no use; stop: nothing can be
// recorded.
enum class Verdict { good, note, look, stop };

struct Finding {
  std::string what;  // "disk speed"
  Verdict verdict = Verdict::look;
  std::string measured;
  std::string cure;  // empty when good
};

const char* to_string(Verdict verdict);  // good | note | LOOK | STOP
// "LOOK  disk speed               writes 40 MB/s" and, below it, the cure; each with its line end.
std::string lines_of(const Finding& finding);
Verdict verdict_from(const std::string& word);  // look for a word it does not know

}  // namespace rotunda::rig
