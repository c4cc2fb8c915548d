#include "simulator/gige/simulated_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulator/gige/big_endian.h"
#include "simulator/gige/chunk_data.h"
#include "simulator/gige/gvsp.h"

namespace rotunda::simulator {
namespace {

using capture::Timestamp;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr nanoseconds kFurthestAction = 60s;  // a schedule beyond is taken for another clock's time
constexpr std::size_t kMaxTestPackets = 256;  // waiting for the sender
constexpr nanoseconds kFlashWrite = 1200ms, kFlashRead = 300ms;
constexpr std::uint32_t kReset = 1, kLatch = 2;  // timestamp control

std::uint64_t ticks(Timestamp at) {
  return static_cast<std::uint64_t>(at.time_since_epoch().count());
}

// The MAC address with FF FE in its middle (IEEE 1588-2008, 7.5.2.2.2).
std::uint64_t clock_identity(const std::array<std::uint8_t, 6>& mac) {
  const std::array<std::uint8_t, 8> bytes{mac[0], mac[1], mac[2], 0xFF, 0xFE, mac[3], mac[4], mac[5]};
  return load_be<std::uint64_t>(bytes, 0);
}

}  // namespace

SimulatedCamera::SimulatedCamera(const GigeCameraOptions& options, PtpStatus role, std::uint16_t stream_source_port,
                                 Timestamp powered_up)
    : options_(options),
      role_(role),
      stream_source_port_(stream_source_port),
      factory_(options),
      registers_(factory_),
      user_sets_(registers_.settings()),
      clock_(options.clock, role, powered_up) {
  power_cycle(powered_up);
}

void SimulatedCamera::power_cycle(Timestamp at) {
  registers_ = factory_;
  registers_.set(reg::kSourcePort, stream_source_port_);
  registers_.set64(reg::kPtpClockId, clock_identity(options_.mac));
  if (user_sets_.user_name)
    for (std::uint32_t word = 0; word < 4; ++word)
      registers_.set(reg::kUserName + 4 * word, (*user_sets_.user_name)[word]);
  if (const auto& set = user_sets_.settings(user_sets_.at_power_up)) registers_.restore(*set);
  registers_.set(reg::kUserSetDefault, user_sets_.at_power_up);
  registers_.set(reg::kUserSetSelector, user_sets_.at_power_up);
  acquisition_.stop();
  test_packets_.clear();
  thermometer_ = {};
  auto clock = options_.clock;
  clock.ptp = registers_.get(reg::kPtpEnable) == 1;
  clock_ = CameraClock(clock, role_, at);
  set_ptp(clock.ptp, at);
}

// --- registers --------------------------------------------------------------------------------------------------

std::optional<std::vector<std::uint8_t>> SimulatedCamera::read(std::uint32_t address, std::size_t bytes, Timestamp at) {
  if (address < reg::kDescription) refresh(at);
  const auto memory = registers_.read(address, bytes);
  if (!memory) return std::nullopt;
  std::vector<std::uint8_t> values(memory->begin(), memory->end());
  falsify(address, values, at);
  return values;
}

void SimulatedCamera::refresh(Timestamp at) {
  const auto port = static_cast<std::uint32_t>(clock_.status(at));
  registers_.set(reg::kPtpStatus, port);
  registers_.set(reg::kPtpPortState, port);
  registers_.set(reg::kPtpServoStatus, clock_.is_synchronised(at));
  registers_.set(reg::kTemperature, static_cast<std::uint32_t>(std::lround(1000.0 * thermometer_.celsius(at))));
  registers_.set(reg::kLineStatus, line_.is_high(at));
}

GvcpStatus SimulatedCamera::write(std::uint32_t address, std::uint32_t value, Timestamp at) {
  if (is_acquiring() && DeviceRegisters::is_locked_while_acquiring(address)) {
    ++counts_.denied;
    return GvcpStatus::access_denied;
  }
  const auto status = registers_.write(address, value);
  return status == GvcpStatus::success ? react(address, value, at) : status;
}

// Commands clear themselves; what is no command breaks.
GvcpStatus SimulatedCamera::react(std::uint32_t address, std::uint32_t value, Timestamp at) {
  auto status = GvcpStatus::success;
  switch (address) {
    case reg::kAcquisitionStart:
      if (value == 1) start_acquisition(at);
      break;
    case reg::kAcquisitionStop:
      if (value == 1) stop_acquisition(at);
      break;
    case reg::kTriggerSoftware:
      if (value == 1) trigger(TriggerSource::software, at);
      break;
    case reg::kTimestampControl:
      if ((value & kLatch) != 0) latch_timestamp(at);
      if ((value & kReset) != 0) clock_.reset(at);
      break;
    case reg::kTimestampLatch:
      if (value == 1) latch_timestamp(at);
      break;
    case reg::kTimestampReset:
      if (value == 1) clock_.reset(at);
      break;
    case reg::kPtpDataSetLatch:
      if (value == 1) latch_ptp(at);
      break;
    case reg::kUserSetSave:
      if (value == 1) status = save_user_set();
      break;
    case reg::kUserSetLoad:
      if (value == 1) status = load_user_set(at);
      break;
    case reg::kTriggerMode:
      acquisition_.change_trigger_mode(value == 1, at);
      return status;
    case reg::kPtpEnable:
      set_ptp(value == 1, at);
      return status;
    case reg::kGvcpConfiguration:
      set_ptp((value & kPtpConfigured) != 0, at);
      return status;
    case reg::kPacketSize:
      fire_test_packet(value);
      return status;
    case reg::kUserSetDefault:
      user_sets_.at_power_up = value;
      return status;
    default:
      if (address >= reg::kUserName && address < reg::kUserName + 16) {
        auto& name = user_sets_.user_name.emplace();
        for (std::uint32_t word = 0; word < 4; ++word) name[word] = registers_.get(reg::kUserName + 4 * word);
      }
      return status;
  }
  registers_.set(address, 0);
  return status;
}

void SimulatedCamera::latch_timestamp(Timestamp at) {
  registers_.set64(reg::kTimestampHigh, ticks(camera_time(at)));
}

void SimulatedCamera::latch_ptp(Timestamp at) {
  const auto offset = clock_.offset_from_master(at) + faults_.clock_error(at);
  registers_.set64(reg::kPtpOffset, static_cast<std::uint64_t>(offset.count()));
}

// The feature and the bit of the GVCP configuration register are one.
void SimulatedCamera::set_ptp(bool enabled, Timestamp at) {
  if (enabled) {
    clock_.enable_ptp(at);
  } else {
    clock_.disable_ptp(at);
  }
  const std::uint32_t others = registers_.get(reg::kGvcpConfiguration) & ~kPtpConfigured;
  registers_.set(reg::kGvcpConfiguration, others | (enabled ? kPtpConfigured : 0));
  registers_.set(reg::kPtpEnable, enabled);
}

void SimulatedCamera::fire_test_packet(std::uint32_t value) {
  registers_.set(reg::kPacketSize, value & ~kFireTestPacket);
  if ((value & kFireTestPacket) == 0 || test_packets_.size() >= kMaxTestPackets) return;
  constexpr std::size_t kIpAndUdp = 28;
  test_packets_.push_back({stream_destination(), (value & kPacketSizeMask) - kIpAndUdp});
}

GvcpStatus SimulatedCamera::save_user_set() {
  if (!user_sets_.save(registers_.get(reg::kUserSetSelector), registers_.settings())) return GvcpStatus::write_protect;
  effort_ += kFlashWrite;
  return GvcpStatus::success;
}

GvcpStatus SimulatedCamera::load_user_set(Timestamp at) {
  const auto& set = user_sets_.settings(registers_.get(reg::kUserSetSelector));
  if (!set) return GvcpStatus::invalid_parameter;
  registers_.restore(*set);
  set_ptp(registers_.get(reg::kPtpEnable) == 1, at);
  effort_ += kFlashRead;
  return GvcpStatus::success;
}

nanoseconds SimulatedCamera::take_effort() {
  return std::exchange(effort_, 0ns);
}

std::optional<TestPacket> SimulatedCamera::take_test_packet() {
  if (test_packets_.empty()) return std::nullopt;
  const auto packet = test_packets_.front();
  test_packets_.pop_front();
  return packet;
}

// --- triggers ---------------------------------------------------------------------------------------------------

AcquisitionSettings SimulatedCamera::acquisition_settings() const {
  AcquisitionSettings settings{.mode = static_cast<AcquisitionMode>(registers_.get(reg::kAcquisitionMode)),
                               .frame_count = registers_.get(reg::kFrameCount),
                               .triggered = registers_.get(reg::kTriggerMode) == 1,
                               .source = static_cast<TriggerSource>(registers_.get(reg::kTriggerSource)),
                               .trigger_delay = nanoseconds{registers_.get(reg::kTriggerDelay)},
                               .exposure = nanoseconds{registers_.get(reg::kExposureTime)},
                               .extended_ids = (registers_.get(reg::kGvspConfiguration) & kExtendedIdEnable) != 0};
  const bool limited = registers_.get(reg::kFrameRateEnable) == 1;
  const nanoseconds wanted{limited ? 1'000'000'000'000 / registers_.get(reg::kFrameRate)
                                   : 8ULL * registers_.get(reg::kPayloadSize)};  // else what 1 Gb/s carries
  settings.period = std::max(clock_.true_duration(wanted), settings.busy_time());
  return settings;
}

void SimulatedCamera::start_acquisition(Timestamp at) {
  acquisition_.start(acquisition_settings(), at);
  thermometer_.set_streaming(true, at);
}

void SimulatedCamera::stop_acquisition(Timestamp at) {
  acquisition_.stop();
  thermometer_.set_streaming(false, at);
}

bool SimulatedCamera::is_meant_by(const ActionCommand& action) const {
  return action.device_key == registers_.get(reg::kActionDeviceKey) &&
         action.group_key == registers_.get(reg::kActionGroupKey) &&
         (action.group_mask & registers_.get(reg::kActionGroupMask)) != 0;
}

GvcpStatus SimulatedCamera::carry_out(const ActionCommand& action, Timestamp received) {
  if (!action.at) return trigger(TriggerSource::action1, received);
  if (!clock_.is_synchronised(received)) return GvcpStatus::no_reference_time;
  if (*action.at > received + kFurthestAction) return GvcpStatus::invalid_parameter;
  const Timestamp at = *action.at < Timestamp{}
                           ? *action.at
                           : clock_.true_time(*action.at - faults_.clock_error(*action.at));  // when its clock shows it
  const bool late = at < received;
  const auto status = trigger(TriggerSource::action1, late ? received : at);
  if (!late) return status;
  ++counts_.late_actions;
  return GvcpStatus::action_late;
}

void SimulatedCamera::set_line0(bool high, Timestamp at) {
  line_.set(high, at);
}

nanoseconds SimulatedCamera::debounce() const {
  return nanoseconds{registers_.get(reg::kLineDebounce)};
}

void SimulatedCamera::advance(Timestamp now) {
  const auto activation = static_cast<TriggerActivation>(registers_.get(reg::kTriggerActivation));
  while (const auto edge = line_.take_edge(now, debounce()))
    if (edge->fires(activation)) trigger(TriggerSource::line0, edge->at);
}

GvcpStatus SimulatedCamera::trigger(TriggerSource source, Timestamp at) {
  return acquisition_.trigger(acquisition_settings(), source, at, faults_, counts_);
}

// --- frames -----------------------------------------------------------------------------------------------------

Timestamp SimulatedCamera::camera_time(Timestamp at) const {
  return clock_.reading(at) + faults_.clock_error(at);
}

Endpoint SimulatedCamera::stream_destination() const {
  return {.address = registers_.get(reg::kDestination),
          .port = static_cast<std::uint16_t>(registers_.get(reg::kHostPort))};
}

std::optional<Timestamp> SimulatedCamera::next_due() const {
  std::optional<Timestamp> next;
  if (acquisition_.expects_frame()) next = acquisition_.next_due(acquisition_settings());
  if (const auto edge = line_.next_edge(debounce()); edge && (!next || *edge < *next)) next = edge;
  return next;
}

std::optional<DueFrame> SimulatedCamera::take_due(Timestamp now) {
  advance(now);
  while (acquisition_.expects_frame()) {
    const auto settings = acquisition_settings();
    const auto exposure = acquisition_.take_due(settings, now, faults_);
    if (!exposure) return std::nullopt;
    if (!is_acquiring()) thermometer_.set_streaming(false, now);
    auto frame = frame_of(*exposure, settings);
    if (!withholds(frame)) return frame;
  }
  return std::nullopt;
}

DueFrame SimulatedCamera::frame_of(const StartedExposure& exposure, const AcquisitionSettings& settings) {
  const Timestamp start = exposure.start;
  const auto wrong = faults_.in_force(start);
  counts_.faults[FaultKind::clock_drift] += wrong.clock_drifts;
  DueFrame frame{.block = exposure.block,
                 .extended_ids = settings.extended_ids,
                 .exposure_start = start,
                 .due = start + settings.busy_time(),
                 .exposure = settings.exposure,
                 .stamp = clock_.reading(start) + wrong.clock_error,
                 .destination = stream_destination(),
                 .packet_size = registers_.get(reg::kPacketSize) & kPacketSizeMask,
                 .pixel_code = registers_.get(reg::kPixelFormat),
                 .width = registers_.get(reg::kWidth),
                 .height = registers_.get(reg::kHeight),
                 .offset_x = registers_.get(reg::kOffsetX),
                 .offset_y = registers_.get(reg::kOffsetY),
                 .packet_delay = nanoseconds{registers_.get(reg::kPacketDelay)},
                 .transmission_delay = nanoseconds{registers_.get(reg::kTransmissionDelay)},
                 .chunks = {},
                 .image_settings = {},
                 .faults = wrong};
  frame.chunks = chunks_of(frame);
  if (const auto now = registers_.image_settings(); now != factory_.image_settings()) frame.image_settings = now;
  return frame;
}

std::vector<std::uint8_t> SimulatedCamera::chunks_of(const DueFrame& frame) const {
  if (registers_.get(reg::kChunkModeActive) == 0) return {};
  return chunk_data(picture_bytes(frame.pixel_code, frame.width, frame.height),
                    {.enabled = registers_.enabled_chunks(),
                     .exposure_start = frame.stamp,
                     .exposure = frame.exposure,
                     .line_status = line_.is_high(frame.exposure_start) ? 1U : 0U,
                     .frame_id = frame.block,
                     .gain = registers_.get(reg::kGain)});
}

// --- faults -----------------------------------------------------------------------------------------------------

double SimulatedCamera::temperature(Timestamp at) const {
  const double usual = thermometer_.celsius(at);
  const auto heat = faults_.in_force(at).heat;
  return heat ? std::max(0.0, usual + (heat->fault.celsius - usual) * heat->progress) : usual;
}

// What a client reads of `memory`, which lies at `address`, instead of what is there.
void SimulatedCamera::falsify(std::uint32_t address, std::span<std::uint8_t> memory, Timestamp at) {
  const auto tell = [&](std::uint32_t where, std::uint32_t value) {
    if (where >= address && where - address < memory.size()) store_be(memory, where - address, value);
  };
  const auto wrong = faults_.in_force(at);
  if (wrong.heat) tell(reg::kTemperature, static_cast<std::uint32_t>(std::lround(1000.0 * temperature(at))));
  const auto change = wrong.wrong_payload_size.register_change;
  if (change == 0 || reg::kPayloadSize < address || reg::kPayloadSize - address >= memory.size()) return;
  ++counts_.faults[FaultKind::wrong_payload_size];
  tell(reg::kPayloadSize,
       static_cast<std::uint32_t>(std::max<std::int64_t>(0, registers_.get(reg::kPayloadSize) + change)));
}

// Frames that are exposed and never leave.
bool SimulatedCamera::withholds(const DueFrame& frame) {
  const auto& wrong = frame.faults;
  const bool too_hot =
      wrong.heat && wrong.heat->fault.stops_at && temperature(frame.exposure_start) >= *wrong.heat->fault.stops_at;
  if (wrong.stalled)
    ++counts_.faults[FaultKind::stall];
  else if (too_hot)
    ++counts_.faults[FaultKind::over_temperature];
  return wrong.stalled || too_hot;
}

}  // namespace rotunda::simulator
