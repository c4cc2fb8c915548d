#include "simulator/gige/fault_script.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <set>
#include <system_error>

#include "config/errors.h"

namespace rotunda::simulator {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using namespace std::chrono_literals;

const std::vector<std::string> kCameras{"cam00", "cam01", "cam02", "cam03", "cam04",
                                        "cam05", "cam06", "cam07", "cam08", "cam09"};

FaultScript script_of(const std::string& text) {
  return parse_fault_script(text, "faults.yaml", kCameras);
}

// One entry of a file; its fault.
CameraFault one(const std::string& entry) {
  const auto script = script_of("faults:\n  - { camera: cam03, " + entry + " }\n");
  EXPECT_EQ(script.faults.size(), 1U);
  return script.faults.at(0);
}

template <class Effect>
Effect effect_of(const std::string& entry) {
  return std::get<Effect>(one(entry).fault.effect);
}

std::string problems_of(const std::string& text) {
  try {
    script_of(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

std::string problem_of_entry(const std::string& entry) {
  return problems_of("faults:\n  - { camera: cam03, " + entry + " }\n");
}

}  // namespace

TEST(FaultScript, ReadsWhenWhichCameraAndWhat) {
  const auto script = script_of(
      "seed: 7\n"
      "faults:\n"
      "  - { at: 2s, for: 500ms, camera: cam03, packet_loss: { rate: 2%, burst: 5 } }\n"
      "  - { at: trigger 40 + 20ms, for: 3 triggers, camera: [cam01, cam00, cam01], stall: }\n"
      "  - { camera: all, silence: 1min }\n");
  EXPECT_EQ(script.seed, 7U);
  ASSERT_EQ(script.faults.size(), 3U);
  const auto& [loss, stall, silence] = std::tie(script.faults[0], script.faults[1], script.faults[2]);
  EXPECT_THAT(loss.cameras, ElementsAre(3));
  EXPECT_EQ(loss.fault.after, 2s);
  EXPECT_EQ(loss.fault.lasts, 500ms);
  EXPECT_DOUBLE_EQ(std::get<PacketLoss>(loss.fault.effect).rate, 0.02);
  EXPECT_EQ(std::get<PacketLoss>(loss.fault.effect).burst, 5U);
  EXPECT_THAT(stall.cameras, ElementsAre(1, 0));
  EXPECT_EQ(stall.fault.at_trigger, 40U);
  EXPECT_EQ(stall.fault.after, 20ms);
  EXPECT_EQ(stall.fault.triggers, 3U);
  EXPECT_FALSE(stall.fault.lasts);
  EXPECT_EQ(silence.cameras.size(), 10U);
  EXPECT_EQ(silence.fault.lasts, 1min);
}

TEST(FaultScript, ReadsEveryKindInItsShortFormAndItsLong) {
  EXPECT_DOUBLE_EQ(effect_of<Reorder>("reorder: 5 %").rate, 0.05);
  EXPECT_EQ(effect_of<Reorder>("reorder: { rate: 0.1, by: 7 }").by, 7U);
  EXPECT_DOUBLE_EQ(effect_of<Duplicate>("duplicate: 1").rate, 1.0);
  EXPECT_DOUBLE_EQ(effect_of<NetworkError>("network_error: { rate: 10% }").rate, 0.1);
  EXPECT_DOUBLE_EQ(effect_of<StrayPacket>("stray_packet: 100%").rate, 1.0);
  EXPECT_EQ(effect_of<LateFrames>("late_frames: 1.5ms").by, 1500us);
  EXPECT_DOUBLE_EQ(effect_of<MissingTrailer>("missing_trailer: 100%").rate, 1.0);
  EXPECT_EQ(effect_of<CorruptedLeader>("corrupted_leader: block_id").flaw, LeaderFlaw::block_id);
  EXPECT_DOUBLE_EQ(effect_of<CorruptedLeader>("corrupted_leader: { what: width, rate: 20% }").rate, 0.2);
  EXPECT_EQ(effect_of<WrongPayloadSize>("wrong_payload_size: -1000").sent_change, -1000);
  EXPECT_EQ(effect_of<WrongPayloadSize>("wrong_payload_size: { register: +4096 }").register_change, 4096);
  EXPECT_EQ(one("reboot:").fault.lasts, 5s);
  EXPECT_EQ(one("reboot: 9s").fault.lasts, 9s);
  EXPECT_TRUE(effect_of<ControlStolen>("control_stolen: 5s").exclusive);
  EXPECT_FALSE(effect_of<ControlStolen>("control_stolen: { exclusive: false }").exclusive);
  EXPECT_EQ(effect_of<SlowRegisters>("slow_registers: 300ms").by, 300ms);
  const auto heat = effect_of<OverTemperature>("over_temperature: { to: 92C, within: 30s, stops_at: 85 }");
  EXPECT_DOUBLE_EQ(heat.celsius, 92.0);
  EXPECT_EQ(heat.within, 30s);
  EXPECT_EQ(heat.stops_at, 85.0);
  EXPECT_EQ(effect_of<LateTrigger>("late_trigger: 5ms").by, 5ms);
  EXPECT_EQ(one("missed_trigger: 3").fault.triggers, 3U);
  EXPECT_EQ(effect_of<MissedTrigger>("missed_trigger: { every: 5 }").every, 5U);
  EXPECT_EQ(effect_of<DoubledTrigger>("doubled_trigger: { next: 2, after: 12ms }").after, 12ms);
  EXPECT_EQ(effect_of<ClockStep>("clock_step: -2ms").by, -2ms);
  EXPECT_DOUBLE_EQ(effect_of<ClockDrift>("clock_drift: 50ppm").ppm, 50.0);
}

TEST(FaultScript, TellsEveryMistakeWithItsPlaceAndWhatWasExpected) {
  const auto told = problems_of(
      "sede: 3\n"
      "faults:\n"
      "  - { camera: cam99, silense: 2s }\n"
      "  - { at: soon, camera: cam01, packet_loss: { rate: lots, brust: 3 } }\n"
      "  - { camera: cam02 }\n"
      "  - cam03\n"
      "  - { stall: 2s }\n");
  EXPECT_THAT(told, HasSubstr("faults.yaml:1:1: sede: unknown key; did you mean \"seed\"?"));
  EXPECT_THAT(told, HasSubstr("faults.yaml:3:15: faults[0].camera: expected all, or cameras out of cam00, cam01"));
  EXPECT_THAT(told, HasSubstr("faults.yaml:3:22: faults[0].silense: unknown key; did you mean \"silence\"?"));
  EXPECT_THAT(told, HasSubstr("faults.yaml:4:11: faults[1].at: expected a time such as 2s, or a trigger"));
  EXPECT_THAT(told, HasSubstr("faults.yaml:4:53: faults[1].packet_loss.rate: expected a share such as 1% or 0.01, "
                              "found \"lots\""));
  EXPECT_THAT(told, HasSubstr("faults.yaml:4:59: faults[1].packet_loss.brust: unknown key; did you mean \"burst\"?"));
  EXPECT_THAT(told, HasSubstr("faults.yaml:5:5: faults[2]: names no fault; expected one of clock_drift, clock_step"));
  EXPECT_THAT(told, HasSubstr("faults.yaml:6:5: faults[3]: expected keys and values, found \"cam03\""));
  EXPECT_THAT(told, HasSubstr("faults.yaml:7:5: faults[4].camera: is missing; expected all, or cameras out of"));
}

TEST(FaultScript, RefusesWhatCannotBe) {
  for (const char* entry : {"at: 2, stall: 1s",
                            "at: -2s, stall: 1s",
                            "at: trigger, stall: 1s",
                            "at: trigger 0, stall: 1s",
                            "at: trigger 3 + , stall: 1s",
                            "at: [2s], stall: 1s",
                            "for: forever, stall:",
                            "for: 0s, stall:",
                            "for: 0 triggers, stall:",
                            "for: 3 triggersx, stall:",
                            "for: 25h, stall:",
                            "for: 2s, stall: 3s",
                            "for: 2s, missed_trigger: 3",
                            "packet_loss: 101%",
                            "packet_loss: -1%",
                            "packet_loss: nan",
                            "packet_loss: 1e999",
                            "packet_loss:",
                            "packet_loss: []",
                            "packet_loss: { burst: 3 }",
                            "packet_loss: { rate: 1%, burst: 0 }",
                            "packet_loss: { rate: 1%, burst: 99999999999999999999 }",
                            "late_frames: 0s",
                            "late_frames: -3ms",
                            "corrupted_leader: colour",
                            "wrong_payload_size: { }",
                            "wrong_payload_size: 1.5",
                            "wrong_payload_size: 1e18",
                            "reboot: 2",
                            "slow_registers: {}",
                            "control_stolen: { exclusive: maybe }",
                            "over_temperature: 1000",
                            "over_temperature: { within: 3s }",
                            "missed_trigger: 0",
                            "missed_trigger: { next: 1, every: 2 }",
                            "missed_trigger: { }",
                            "clock_step: fast",
                            "clock_drift: 2%",
                            "clock_drift: { ppm: 1e9 }",
                            "stall: { 3: 4 }"})
    EXPECT_THAT(problem_of_entry(entry), AllOf(HasSubstr("faults.yaml:2:"), HasSubstr("faults[0]"))) << entry;
}

TEST(FaultScript, RefusesFilesThatAreNone) {
  EXPECT_THAT(problems_of(""), HasSubstr("faults.yaml"));
  EXPECT_THAT(problems_of("- a\n"), HasSubstr("expected keys and values"));
  EXPECT_THAT(problems_of("faults: 3\n"), HasSubstr("faults.yaml:1:9: faults: expected a list"));
  EXPECT_THAT(problems_of("seed: 3\n"), HasSubstr("faults: is missing"));
  EXPECT_THAT(problems_of("faults: [\n"), HasSubstr("is not YAML"));
  EXPECT_THAT(problems_of("faults: []\n---\nfaults: []\n"), HasSubstr("more than one"));
  EXPECT_THAT(problems_of("seed: -1\nfaults: []\n"), HasSubstr("faults.yaml:1:7: seed: expected a whole number"));
  EXPECT_THAT(problems_of(std::string(200'000, '[')), HasSubstr("is not YAML"));
  EXPECT_THROW(load_fault_script("/nonexistent/faults.yaml", kCameras), std::system_error);
  EXPECT_THROW(load_fault_script("/dev/zero", kCameras), ConfigError);
}

TEST(FaultScript, TheExampleFileShowsEveryKind) {
  const auto script = load_fault_script(ROTUNDA_SOURCE_DIR "/config/faults.example.yaml", kCameras);
  EXPECT_EQ(script.seed, 7U);
  std::set<FaultKind> kinds;
  for (const auto& entry : script.faults) kinds.insert(kind_of(entry.fault.effect));
  EXPECT_EQ(kinds.size(), kFaultKinds);
}

TEST(FaultRequest, IsAFaultOrAQuestion) {
  const auto parse = [](const std::string& line) { return parse_fault_request(line, kCameras); };
  const auto two = parse("{ cam03: { silence: 2s }, all: { at: trigger 9, packet_loss: 1% } }");
  EXPECT_EQ(two.what, FaultRequest::What::add);
  ASSERT_EQ(two.script.faults.size(), 2U);
  EXPECT_THAT(two.script.faults[0].cameras, ElementsAre(3));
  EXPECT_EQ(two.script.faults[1].fault.at_trigger, 9U);
  EXPECT_EQ(parse("cam03: {silence: 2s}").script.faults.size(), 1U);
  EXPECT_EQ(parse(R"({"camera": ["cam01", "cam02"], "clock_step": "2ms"})").script.faults.at(0).cameras.size(), 2U);
  EXPECT_EQ(parse("seed: 12").script.seed, 12U);
  EXPECT_EQ(parse("status").what, FaultRequest::What::status);
  EXPECT_EQ(parse("\"status\"").what, FaultRequest::What::status);
  EXPECT_EQ(parse("help").what, FaultRequest::What::help);
  EXPECT_EQ(parse("clear").cameras.size(), 10U);
  EXPECT_THAT(parse("clear: cam04").cameras, ElementsAre(4));
}

TEST(FaultRequest, TellsWhatIsWrongWithIt) {
  const auto problem = [](const std::string& line) -> std::string {
    try {
      parse_fault_request(line, kCameras);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem("cam77: { silence: 2s }"), HasSubstr("request:1:1: cam77: unknown; expected all, or cameras"));
  EXPECT_THAT(problem("cam03: { silence: 2 }"), HasSubstr("request:1:19: cam03.silence.for: expected a duration"));
  EXPECT_THAT(problem("cam03: 2s"), HasSubstr("cam03: expected keys and values"));
  EXPECT_THAT(problem("{ silence: 2s }"), HasSubstr("camera: is missing"));
  EXPECT_THAT(problem("reboot"), HasSubstr("expected status, clear, help, or a fault such as"));
  EXPECT_THAT(problem("&a [*a]"), HasSubstr("anchors"));
  EXPECT_THAT(problem("clear: cam77"), HasSubstr("clear: expected all"));
  EXPECT_THAT(problem("{}"), HasSubstr("expected"));
}

// Honest requests with bytes turned, dropped and doubled, and noise: refused or read, never worse.
TEST(FaultRequest, SurvivesHostileLines) {
  const std::vector<std::string> honest{
      "cam03: { silence: 2s }",
      R"({"camera": "all", "packet_loss": {"rate": "1%", "burst": 3}, "at": "trigger 4 + 2ms"})",
      "{ camera: [cam01, cam02], over_temperature: { to: 92, within: 30s, stops_at: 85 }, for: 3 triggers }",
      "clear: cam04",
      "seed: 7",
      "status"};
  const std::string marks = "{}[]:,-?!|>'\"%@`#\\ \t\n\r0e9\x80\xff";
  std::mt19937 random(3);
  int refused = 0, read = 0;
  for (int k = 0; k < 4000; ++k) {
    std::string line = honest[static_cast<std::size_t>(k) % honest.size()];
    for (unsigned edits = 1 + random() % 4; edits > 0; --edits) {
      const auto at = random() % (line.size() + 1);
      if (random() % 3 == 0)
        line.erase(at, 1 + random() % 5);
      else
        line.insert(at, 1 + random() % 2, random() % 2 ? marks[random() % marks.size()] : static_cast<char>(random()));
    }
    try {
      parse_fault_request(line, kCameras);
      ++read;
    } catch (const ConfigError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(read, 10);
  EXPECT_THROW(parse_fault_request(std::string(4096, '{'), kCameras), ConfigError);
  EXPECT_THROW(parse_fault_request(std::string(4096, '\0'), kCameras), ConfigError);
}

}  // namespace rotunda::simulator
