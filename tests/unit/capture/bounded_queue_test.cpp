#include "capture/base/bounded_queue.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace rotunda::capture {
namespace {

using namespace std::chrono_literals;

TEST(BoundedQueue, HandsItemsOnInOrder) {
  BoundedQueue<int> queue(3);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.try_push(i));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(queue.pop(), i);
}

TEST(BoundedQueue, RefusesWhenFullAndLeavesTheItemWithItsOwner) {
  BoundedQueue<std::unique_ptr<int>> queue(1);
  EXPECT_TRUE(queue.try_push(std::make_unique<int>(1)));
  auto second = std::make_unique<int>(2);
  EXPECT_FALSE(queue.try_push(std::move(second)));
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(queue.dropped(), 0u);
}

TEST(BoundedQueue, DropsTheOldestAndCountsItWhenAskedTo) {
  BoundedQueue<int> queue(2);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(queue.push_drop_oldest(i));
  EXPECT_EQ(queue.dropped(), 3u);
  EXPECT_EQ(queue.size(), 2u);
  EXPECT_EQ(queue.pop(), 3);
  EXPECT_EQ(queue.pop(), 4);
}

TEST(BoundedQueue, ClosedTakesNothingMoreButGivesWhatItHas) {
  BoundedQueue<int> queue(2);
  queue.try_push(7);
  queue.close();
  EXPECT_FALSE(queue.try_push(8));
  EXPECT_FALSE(queue.push(8));
  EXPECT_FALSE(queue.push_drop_oldest(8));
  EXPECT_EQ(queue.pop(), 7);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BoundedQueue, WaitPopGivesUpAfterItsTime) {
  BoundedQueue<int> queue(1);
  EXPECT_EQ(queue.wait_pop(1ms), std::nullopt);
  queue.try_push(1);
  EXPECT_EQ(queue.wait_pop(1ms), 1);
}

TEST(BoundedQueue, StopTokensEndWaitingOnBothSides) {
  BoundedQueue<int> empty(1), full(1);
  full.try_push(1);
  std::optional<int> popped = 0;
  bool pushed = true;
  {
    std::jthread popper([&](std::stop_token stop) { popped = empty.pop(stop); });
    std::jthread pusher([&](std::stop_token stop) { pushed = full.push(2, stop); });
  }
  EXPECT_EQ(popped, std::nullopt);
  EXPECT_FALSE(pushed);
}

TEST(BoundedQueue, LosesNothingBetweenManyThreadsWhenPushWaits) {
  BoundedQueue<int> queue(4);
  constexpr int items = 2000;
  std::atomic<long> sum{0};
  {
    std::vector<std::jthread> consumers;
    for (int c = 0; c < 3; ++c)
      consumers.emplace_back([&] {
        while (const auto item = queue.pop()) sum += *item;
      });
    {
      std::vector<std::jthread> producers;
      for (int p = 0; p < 2; ++p)
        producers.emplace_back([&] {
          for (int i = 1; i <= items; ++i) queue.push(i);
        });
    }
    queue.close();
  }
  EXPECT_EQ(sum, 2L * items * (items + 1) / 2);
}

TEST(BoundedQueue, NeedsACapacity) {
  EXPECT_THROW(BoundedQueue<int>(0), InvalidInput);
}

}  // namespace
}  // namespace rotunda::capture
