#include "capture/source/source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.h"

namespace rotunda::capture {
namespace {

using enum SourceState;

TEST(SourceState, EveryPairOfStatesIsAllowedOrRefusedAsTheHeaderSays) {
  const SourceState states[] = {closed, open, armed, streaming, lost};
  const bool allowed[5][5] = {
      // to: closed, open, armed, streaming, lost
      {true, true, false, false, false},  // from closed
      {true, false, true, false, true},   // open
      {true, false, false, true, true},   // armed
      {true, false, true, false, true},   // streaming
      {true, false, false, false, true},  // lost
  };
  for (int from = 0; from < 5; ++from)
    for (int to = 0; to < 5; ++to) {
      EXPECT_EQ(may_follow(states[from], states[to]), allowed[from][to])
          << to_string(states[from]) << " -> " << to_string(states[to]);
      if (allowed[from][to])
        EXPECT_EQ(checked_transition(states[from], states[to], "cam00"), states[to]);
      else
        EXPECT_THROW(checked_transition(states[from], states[to], "cam00"), InvalidInput);
    }
}

TEST(MakeSource, NamesTheKindsThereAreWhenAskedForAnother) {
  SourceSettings settings;
  settings.camera = "cam07";
  settings.kind = "firewire";
  try {
    make_source(settings);
    FAIL() << "made a firewire source";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("cam07"), testing::HasSubstr("firewire"),
                                             testing::HasSubstr("aravis")));
  }
}

}  // namespace
}  // namespace rotunda::capture
