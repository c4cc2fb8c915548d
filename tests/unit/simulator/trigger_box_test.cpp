#include "simulator/gige/trigger_box.h"

#include <gtest/gtest.h>

namespace rotunda::simulator {

TEST(TriggerBox, ItsDatagramsComeBackAsTheLevelsTheyWere) {
  const capture::Timestamp at{std::chrono::seconds{1'700'000'000}};
  const auto high = parse_line(line_datagram({.high = true, .at = at}));
  ASSERT_TRUE(high);
  EXPECT_TRUE(high->high);
  EXPECT_EQ(high->at, at);
  const auto low = parse_line(line_datagram({.high = false, .at = {}}));
  ASSERT_TRUE(low);
  EXPECT_FALSE(low->high || low->at);
}

TEST(TriggerBox, OtherBytesAreNoEdge) {
  auto datagram = line_datagram({.high = true, .at = {}});
  for (std::size_t size = 0; size < datagram.size(); ++size)
    EXPECT_FALSE(parse_line(std::span{datagram}.first(size))) << size;
  datagram[4] = 2;
  EXPECT_FALSE(parse_line(datagram));
  datagram[4] = 1;
  datagram[8] = 0x80;  // a time before time
  EXPECT_FALSE(parse_line(datagram));
  datagram[8] = 0;
  datagram[0] = 'x';
  EXPECT_FALSE(parse_line(datagram));
}

}  // namespace rotunda::simulator
