// The tests of graphics devices without a desktop; or, with --show, the process that shows something on one, with
// --draw the one that draws the same headless.
#include <gtest/gtest.h>

#include <string_view>

#include "kms_show.h"

int main(int argc, char** argv) {
  const std::string_view task = argc > 1 ? argv[1] : "";
  if (task == "--show") return rotunda::vm::show({argv + 2, argv + argc});
  if (task == "--draw") return rotunda::vm::draw({argv + 2, argv + argc});
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
