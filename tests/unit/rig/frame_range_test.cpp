#include "rig/cli/frame_range.h"

#include <gtest/gtest.h>

#include <limits>

#include "config/errors.h"

namespace rotunda::rig {

TEST(FrameRange, IsHalfOpenWithOpenEnds) {
  EXPECT_EQ(frame_range("3:7"), (std::pair<std::size_t, std::size_t>{3, 7}));
  EXPECT_EQ(frame_range(":7"), (std::pair<std::size_t, std::size_t>{0, 7}));
  EXPECT_EQ(frame_range("5"), (std::pair<std::size_t, std::size_t>{5, 6}));
  EXPECT_EQ(frame_range("5:").second, std::numeric_limits<std::size_t>::max());
}

TEST(FrameRange, RefusesWhatIsNone) {
  for (const auto* text : {"a:b", "7:3", "3:3", "-1:2", "1:2:3", "1.5", "99999999999999999999999"})
    EXPECT_THROW(frame_range(text), InvalidInput) << text;
}

}  // namespace rotunda::rig
