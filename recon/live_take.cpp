#include "recon/live_take.h"

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>

#include "capture/take/take_reader.h"
#include "config/errors.h"
#include "recon/live_reconstruction.h"
#include "recon/take_plates.h"
#include "recon/take_studio.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

constexpr char kMagic[] = {'R', 'L', 'T', '1'};
constexpr std::uint64_t kHeaderBytes = 12;

std::array<char, 4> bytes_of(std::uint32_t value) {
  return {static_cast<char>(value), static_cast<char>(value >> 8), static_cast<char>(value >> 16),
          static_cast<char>(value >> 24)};
}

std::uint32_t u32_of(const std::array<char, 4>& bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<std::uint8_t>(bytes[i])} << (8 * i);
  return value;
}

class LiveTakeWriter {
 public:
  LiveTakeWriter(const fs::path& file, std::size_t frames, double fps)
      : file_(file), part_(file.string() + ".part"), out_(part_, std::ios::binary | std::ios::trunc) {
    const auto rate = static_cast<float>(fps);
    std::uint32_t bits = 0;
    std::memcpy(&bits, &rate, sizeof bits);
    out_.write(kMagic, sizeof kMagic);
    number(static_cast<std::uint32_t>(frames));
    number(bits);
  }
  ~LiveTakeWriter() {
    std::error_code best_effort;
    if (!finished_) fs::remove(part_, best_effort);
  }
  LiveTakeWriter(const LiveTakeWriter&) = delete;
  LiveTakeWriter& operator=(const LiveTakeWriter&) = delete;

  void add(const std::vector<std::uint8_t>& surface) {
    number(static_cast<std::uint32_t>(surface.size()));
    out_.write(reinterpret_cast<const char*>(surface.data()), static_cast<std::streamsize>(surface.size()));
  }
  void finish() {
    out_.close();
    if (!out_) throw std::system_error(errno, std::generic_category(), "cannot write " + part_.string());
    fs::rename(part_, file_);
    finished_ = true;
  }

 private:
  void number(std::uint32_t value) { out_.write(bytes_of(value).data(), 4); }

  fs::path file_, part_;
  std::ofstream out_;
  bool finished_ = false;
};

// Empty where there is no surface.
std::vector<std::uint8_t> packed_frame(const capture::FrameSet& set, const TakeStudio& studio) {
  StageClock clock;
  auto frame = reconstruct_live(set, studio.views, {.bounds = studio.volume}, clock);
  if (!frame.failure.empty()) return {};
  return pack_surface({.trigger = set.trigger, .exposure = set.time, .made = set.time, .mesh = std::move(frame.mesh)});
}

}  // namespace

fs::path live_take_file(const fs::path& take) {
  return take / "recon" / "live.surfaces";
}

LiveTakeReport make_live_take(const fs::path& folder, const std::function<bool()>& go_on) {
  const capture::TakeReader take(folder);
  auto studio = read_take_studio(take, std::nullopt);
  make_live_keys(take, studio.views);
  studio.views.volume.reset();  // live_reconstruction.h
  const auto count = take.frame_set_count();
  fs::create_directories(folder / "recon");
  LiveTakeWriter writer(live_take_file(folder), count, take.info().fps);
  LiveTakeReport report{.frames = count};
  std::vector<std::vector<std::uint8_t>> together(static_cast<std::size_t>(tbb::info::default_concurrency()));
  for (std::size_t first = 0; first < count; first += together.size()) {
    if (!go_on()) return report;
    const auto here = std::min(together.size(), count - first);
    tbb::parallel_for(std::size_t{0}, here, [&](std::size_t i) {
      tbb::task_arena alone(1);
      alone.execute([&] { together[i] = packed_frame(take.read(first + i), studio); });
    });
    for (std::size_t i = 0; i < here; ++i) {
      writer.add(together[i]);
      report.with_surface += !together[i].empty();
    }
  }
  writer.finish();
  report.finished = true;
  return report;
}

LiveTakeReader::LiveTakeReader(const fs::path& file) : file_(file), in_(file, std::ios::binary) {
  if (!in_) throw std::system_error(errno, std::generic_category(), "cannot read " + file.string());
  const auto size = fs::file_size(file);
  std::array<char, 4> four{};
  const auto number = [&](std::uint64_t offset) {
    if (offset + 4 > size) throw CorruptData(file_, offset, "it ends too early");
    in_.seekg(static_cast<std::streamoff>(offset));
    in_.read(four.data(), 4);
    return u32_of(four);
  };
  number(0);
  if (std::memcmp(four.data(), kMagic, sizeof kMagic) != 0)
    throw CorruptData(file_, 0, "these are no live surfaces, or of another version");
  const auto count = number(4), bits = number(8);
  float rate = 0.0F;
  std::memcpy(&rate, &bits, sizeof rate);
  fps_ = rate;
  if (!(fps_ > 0.0 && fps_ < 1e4)) throw CorruptData(file_, 8, "its frame rate is none");
  std::uint64_t offset = kHeaderBytes;
  for (std::uint32_t frame = 0; frame < count; ++frame) {  // each takes four bytes at least: a false count ends soon
    const auto bytes = number(offset);
    if (bytes > size - offset - 4)
      throw CorruptData(file_, offset, fmt::format("frame {} has {} bytes, more than the file", frame, bytes));
    frames_.push_back({offset + 4, bytes});
    offset += 4 + std::uint64_t{bytes};
  }
  if (offset != size) throw CorruptData(file_, offset, "more follows than its frames");
}

std::optional<LiveSurface> LiveTakeReader::read(std::size_t frame) {
  if (frame >= frames_.size())
    throw InvalidInput(fmt::format("{} has {} frames, no frame {}", file_.string(), frames_.size(), frame));
  const auto& place = frames_[frame];
  if (place.bytes == 0) return std::nullopt;
  std::vector<std::uint8_t> bytes(place.bytes);
  in_.clear();
  in_.seekg(static_cast<std::streamoff>(place.offset));
  if (!in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
    throw CorruptData(file_, place.offset, "it ends too early");
  return unpack_surface(bytes);
}

}  // namespace rotunda::recon
