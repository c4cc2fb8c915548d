#include <gtest/gtest.h>

#include <array>
#include <map>
#include <random>
#include <vector>

#include "firmware/trigger_box/trigger_box.h"

namespace {

using Message = std::array<std::uint8_t, TRIGGER_BOX_MESSAGE_BYTES>;

std::uint64_t number(const Message& message, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= static_cast<std::uint64_t>(message[at + i]) << (8 * i);
  return value;
}

struct Edge {
  unsigned line;
  bool high;
  std::uint64_t at;
  bool operator==(const Edge&) const = default;
};

// A box with its timer and what came out of it.
struct Bench {
  trigger_box box{};
  std::uint64_t now = 1'000'000;
  std::vector<Edge> edges;

  explicit Bench(unsigned lines = 2, std::uint64_t step_ps = 8000) {
    trigger_box_init(&box, lines, step_ps, &Bench::set_line, this);
    edges.clear();
  }
  static void set_line(void* self, unsigned line, bool high, std::uint64_t at) {
    static_cast<Bench*>(self)->edges.push_back({line, high, at});
  }
  Message tell(int opcode, std::uint64_t value64 = 0, std::uint16_t line = 0, std::uint32_t value32 = 0) {
    Message message{}, reply{};
    message[0] = static_cast<std::uint8_t>(opcode);
    message[1] = 77;
    message[2] = static_cast<std::uint8_t>(line);
    for (std::size_t i = 0; i < 4; ++i) message[4 + i] = static_cast<std::uint8_t>(value32 >> (8 * i));
    for (std::size_t i = 0; i < 8; ++i) message[8 + i] = static_cast<std::uint8_t>(value64 >> (8 * i));
    trigger_box_command(&box, message.data(), message.size(), now, reply.data());
    EXPECT_EQ(reply[1], 77);
    return reply;
  }
  // As firmware does it: sleeps until the next edge, up to `until`.
  void run(std::uint64_t until) {
    std::uint64_t next = 0;
    while (trigger_box_next_edge(&box, &next) && next <= until) {
      now = std::max(now, next);
      trigger_box_advance(&box, now);
    }
    now = until;
    trigger_box_advance(&box, now);
  }
  std::vector<Message> events() {
    std::vector<Message> all;
    for (Message event{}; trigger_box_pop_event(&box, event.data());) all.push_back(event);
    return all;
  }
};

TEST(TriggerBoxDevice, GivesExactlySoManyPulsesAtTheirMoments) {
  Bench bench;
  bench.tell(TRIGGER_BOX_SET_PERIOD, 40'000'000);
  bench.tell(TRIGGER_BOX_SET_WIDTH, 500'000);
  bench.tell(TRIGGER_BOX_SET_COUNT, 3);
  bench.tell(TRIGGER_BOX_SET_DELAY, 2'000'000, 1);
  const auto started = bench.tell(TRIGGER_BOX_START, 100'000'000);
  EXPECT_EQ(started[2], TRIGGER_BOX_OK);
  EXPECT_EQ(started[3], TRIGGER_BOX_SCHEDULED);
  EXPECT_EQ(number(started, 24, 8), 100'000'000U);
  bench.run(1'000'000'000);
  std::vector<Edge> expected;
  for (std::uint64_t k = 0; k < 3; ++k) {
    const std::uint64_t at = 100'000'000 + k * 40'000'000;
    expected.insert(expected.end(),
                    {{0, true, at}, {0, false, at + 500'000}, {1, true, at + 2'000'000}, {1, false, at + 2'500'000}});
  }
  EXPECT_EQ(bench.edges, expected);
  const auto events = bench.events();
  ASSERT_EQ(events.size(), 4U);
  for (std::uint64_t k = 0; k < 3; ++k) {
    EXPECT_EQ(events[k][0], TRIGGER_BOX_PULSE);
    EXPECT_EQ(number(events[k], 16, 8), k);
    EXPECT_EQ(number(events[k], 8, 8), 100'000'000 + k * 40'000'000);
  }
  EXPECT_EQ(events[3][0], TRIGGER_BOX_DONE);
  EXPECT_EQ(number(events[3], 4, 4), static_cast<std::uint64_t>(TRIGGER_BOX_COUNT_REACHED));
  EXPECT_EQ(number(events[3], 16, 8), 3U);
  EXPECT_EQ(bench.tell(TRIGGER_BOX_STATUS)[3], TRIGGER_BOX_IDLE);
}

TEST(TriggerBoxDevice, StopLetsThePulseUnderWayEndOnEveryLine) {
  Bench bench;
  bench.tell(TRIGGER_BOX_SET_DELAY, 5'000'000, 1);
  bench.tell(TRIGGER_BOX_START, 10'000'000);
  bench.run(12'000'000);  // line 0 has risen and fallen again, line 1 not yet
  bench.tell(TRIGGER_BOX_STOP);
  bench.run(500'000'000);
  ASSERT_EQ(bench.edges.size(), 4U);
  EXPECT_EQ(bench.edges.back(), (Edge{1, false, 16'000'000}));
  EXPECT_EQ(number(bench.events().back(), 4, 4), static_cast<std::uint64_t>(TRIGGER_BOX_STOPPED));
}

TEST(TriggerBoxDevice, ATrainWithoutAnEndEndsWhenTheHostIsSilent) {
  Bench bench;
  bench.tell(TRIGGER_BOX_START, 10'000'000);
  bench.run(2'000'000'000);
  bench.tell(TRIGGER_BOX_STATUS);  // still there
  bench.run(4'900'000'000);
  EXPECT_EQ(bench.box.state, TRIGGER_BOX_RUNNING);
  bench.run(10'000'000'000);
  EXPECT_EQ(bench.box.state, TRIGGER_BOX_IDLE);
  EXPECT_EQ(number(bench.events().back(), 4, 4), static_cast<std::uint64_t>(TRIGGER_BOX_HOST_SILENT));
  EXPECT_LT(bench.edges.back().at, 5'100'000'000U);
}

TEST(TriggerBoxDevice, ACountedTrainNeedsNoHost) {
  Bench bench;
  bench.tell(TRIGGER_BOX_SET_COUNT, 200);
  bench.tell(TRIGGER_BOX_START, 10'000'000);
  bench.run(20'000'000'000);
  EXPECT_EQ(bench.box.begun, 200U);
}

TEST(TriggerBoxDevice, RefusesWhatItCannotDo) {
  Bench bench;
  const auto status = [](const Message& reply) { return static_cast<int>(reply[2]); };
  EXPECT_EQ(status(bench.tell(99)), TRIGGER_BOX_UNKNOWN_OPCODE);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_SET_PERIOD, 10)), TRIGGER_BOX_OUT_OF_RANGE);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_SET_PERIOD, ~0ULL)), TRIGGER_BOX_OUT_OF_RANGE);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_SET_DELAY, 0, 2)), TRIGGER_BOX_OUT_OF_RANGE);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_SET_LINES, 0, 0, 4)), TRIGGER_BOX_OUT_OF_RANGE);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_START, 5)), TRIGGER_BOX_TOO_LATE);
  bench.tell(TRIGGER_BOX_SET_WIDTH, 30'000'000);
  bench.tell(TRIGGER_BOX_SET_DELAY, 10'000'000, 1);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_START)), TRIGGER_BOX_DOES_NOT_FIT);
  bench.tell(TRIGGER_BOX_SET_WIDTH, 1'000'000);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_START)), TRIGGER_BOX_OK);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_SET_PERIOD, 40'000'000)), TRIGGER_BOX_BUSY);
  EXPECT_EQ(status(bench.tell(TRIGGER_BOX_START)), TRIGGER_BOX_BUSY);
  Message reply{};
  trigger_box_command(&bench.box, nullptr, 0, bench.now, reply.data());
  EXPECT_EQ(status(reply), TRIGGER_BOX_BAD_MESSAGE);
}

TEST(TriggerBoxDevice, TellsPeriodsAsWholeStepsOfItsClock) {
  Bench bench(1, 1'000'000);  // a microsecond timer
  EXPECT_EQ(number(bench.tell(TRIGGER_BOX_SET_PERIOD, 33'366'700), 24, 8), 33'367'000U);
  EXPECT_EQ(number(bench.tell(TRIGGER_BOX_HELLO), 4, 4), (TRIGGER_BOX_PROTOCOL << 16) + 1U);
}

TEST(TriggerBoxDevice, AnActiveLowLineRestsHigh) {
  Bench bench;
  bench.tell(TRIGGER_BOX_SET_LINES, 2, 0, 3);  // both on, line 1 active low
  bench.edges.clear();
  bench.tell(TRIGGER_BOX_SET_COUNT, 1);
  bench.tell(TRIGGER_BOX_START, 10'000'000);
  bench.run(20'000'000);
  std::map<unsigned, std::vector<bool>> levels;
  for (const auto& edge : bench.edges) levels[edge.line].push_back(edge.high);
  EXPECT_EQ(levels[0], (std::vector<bool>{true, false}));
  EXPECT_EQ(levels[1], (std::vector<bool>{false, true}));
}

TEST(TriggerBoxDevice, CountsEventsNobodyFetched) {
  Bench bench;
  bench.tell(TRIGGER_BOX_SET_COUNT, 100);
  bench.tell(TRIGGER_BOX_START, 10'000'000);
  bench.run(10'000'000'000);
  EXPECT_EQ(number(bench.tell(TRIGGER_BOX_STATUS), 24, 8), 100U + 1U - TRIGGER_BOX_EVENTS);
  const auto events = bench.events();
  ASSERT_EQ(events.size(), static_cast<std::size_t>(TRIGGER_BOX_EVENTS));
  EXPECT_EQ(number(events[0], 16, 8), 37U);  // the oldest went
}

// Whatever bytes come, lines never pulse but between START and the end, and each rise has its fall.
TEST(TriggerBoxDevice, HoldsItsLinesWhateverItIsSent) {
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    Bench bench(1 + random() % TRIGGER_BOX_MAX_LINES, 1 + random() % 2'000'000);
    for (int i = 0; i < 40; ++i) {
      Message message{}, reply{};
      for (auto& byte : message) byte = static_cast<std::uint8_t>(random() % 4 ? 0 : random());
      message[0] = static_cast<std::uint8_t>(random() % 11);
      trigger_box_command(&bench.box, message.data(), random() % 8 ? message.size() : random() % 32, bench.now,
                          reply.data());
      bench.run(bench.now + random() % 100'000'000);
    }
    bench.tell(TRIGGER_BOX_STOP);
    std::uint64_t next = 0;
    for (int i = 0; i < 100 && trigger_box_next_edge(&bench.box, &next); ++i) bench.run(next);
    EXPECT_EQ(bench.box.state, TRIGGER_BOX_IDLE);
    EXPECT_EQ(number(bench.tell(TRIGGER_BOX_STATUS), 4, 4), 0U) << "a line is still active";
  }
}

}  // namespace
