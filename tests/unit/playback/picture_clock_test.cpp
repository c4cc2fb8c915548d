#include "playback/picture_clock.h"

#include <gtest/gtest.h>

namespace rotunda::playback {
namespace {

void hear(DetailKeeper& detail, double seconds, double each) {
  for (double heard = 0.0; heard < seconds; heard += each) detail.hear(each);
}

TEST(DetailKeeper, KeepsTheFinestWhilePicturesAreInTime) {
  DetailKeeper detail;
  hear(detail, 10.0, 0.03);
  EXPECT_EQ(detail.coarser(), 0);
  detail.hear(0.4);  // one slow picture
  hear(detail, 1.0, 0.012);
  EXPECT_EQ(detail.coarser(), 0);
}

TEST(DetailKeeper, GoesCoarserAsFarAsNeededAndFinerAgain) {
  DetailKeeper detail;
  hear(detail, 1.0, 0.06);
  EXPECT_EQ(detail.coarser(), 1);
  hear(detail, 10.0, 0.03);  // in time, but a finer level would not be
  EXPECT_EQ(detail.coarser(), 1);
  hear(detail, 20.0, 0.06);
  EXPECT_EQ(detail.coarser(), 2);  // and no further
  hear(detail, 10.0, 0.01);
  EXPECT_EQ(detail.coarser(), 0);
}

TEST(DetailKeeper, TriesFinerLevelsEverMoreSeldomWhereTheyAreTooSlow) {
  DetailKeeper detail;
  int tries = 0;
  for (double passed = 0.0; passed < 120.0;) {  // the finest takes five times as long as the next
    const double took = detail.coarser() == 0 ? 0.06 : 0.012;
    const int before = detail.coarser();
    detail.hear(took);
    tries += detail.coarser() < before;
    passed += took;
  }
  EXPECT_GE(tries, 3);
  EXPECT_LE(tries, 7);  // without patience thirty
  EXPECT_EQ(detail.coarser(), 1);
}

}  // namespace
}  // namespace rotunda::playback
