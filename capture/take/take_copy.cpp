#include "capture/take/take_copy.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "capture/take/take_writer.h"
#include "capture/take/workplace.h"
#include "config/errors.h"

namespace rotunda::capture {
namespace {

namespace fs = std::filesystem;

std::pair<std::size_t, std::size_t> range_within(const TakeReader& take, std::pair<std::size_t, std::size_t> wanted) {
  const auto [from, to] = std::pair(wanted.first, std::min(wanted.second, take.frame_set_count()));
  if (from >= to)
    throw InvalidInput(fmt::format("take {} has the frame sets 0 to {}; none of them is in {}:{}", take.info().name,
                                   take.frame_set_count(), wanted.first, wanted.second));
  return {from, to};
}

fs::path if_there(const fs::path& file) {
  return fs::exists(file) ? file : fs::path();
}

TakeWriterOptions options_like(const TakeReader& take, const fs::path& folder) {
  TakeWriterOptions options;
  options.folder = folder;
  options.slate = take.info().slate;
  options.note = take.info().note;
  options.scene = take.info().scene;
  options.shot = take.info().shot;
  options.take_number = take.info().take_number;
  options.rig = take.info().rig;
  options.fps = take.info().fps;
  options.cameras = take.info().cameras;
  options.rig_file = if_there(take.folder() / "rig.yaml");
  options.calibration_file = if_there(calibration_file(take.folder()));
  options.reserve_bytes = 0;  // every write looks for room
  return options;
}

void copy_mattes(const TakeReader& take, const fs::path& folder, std::pair<std::size_t, std::size_t> range) {
  for (const auto& camera : take.info().cameras)
    for (std::size_t frame = range.first; frame < range.second; ++frame) {
      const auto from = matte_file(take.folder(), camera.name, frame);
      if (!fs::exists(from)) continue;
      const auto to = matte_file(folder, camera.name, frame - range.first);
      fs::create_directories(to.parent_path());
      fs::copy_file(from, to);
    }
}

void copy_remarks(const TakeReader& take, TakeWriter& writer, std::uint64_t trigger) {
  for (const auto& mark : take.journal().marks)
    if (mark.trigger == trigger) writer.mark(mark.text);
  for (const auto& incident : take.journal().incidents)
    if (incident.trigger == trigger) writer.incident(incident.text);
}

void write_frame_sets(const TakeReader& take, const fs::path& folder, std::pair<std::size_t, std::size_t> range,
                      const Progress& progress, const std::stop_token& stop) {
  TakeWriter writer(options_like(take, folder));
  for (std::size_t index = range.first; index < range.second; ++index) {
    if (stop.stop_requested())
      throw std::system_error(std::make_error_code(std::errc::operation_canceled), "copying " + take.info().name);
    const FrameSet set = take.read(index);
    writer.write(set);
    copy_remarks(take, writer, set.trigger);
    if (progress) progress(index + 1 - range.first, range.second - range.first);
  }
  writer.set_circled(take.info().circled);
  writer.finish(take.info().state == TakeState::recording ? TakeState::recovered : take.info().state);
}

}  // namespace

TakeInfo copy_take(const TakeReader& take, const TakeCopyOptions& options, const Progress& progress,
                   std::stop_token stop) {
  const auto range = range_within(take, options.frame_sets);
  const auto name = options.folder.filename().string();
  if (!valid_take_name(name)) throw InvalidInput("'" + name + "' cannot be the name of a take");
  if (fs::exists(options.folder))
    throw InvalidInput(options.folder.string() + " exists already: choose another name for the take");
  Workplace workplace(options.folder.parent_path() / ("." + name + ".copying"));
  const auto part = workplace.folder() / name;
  write_frame_sets(take, part, range, progress, stop);
  if (fs::exists(take.folder() / "background"))
    fs::copy(take.folder() / "background", part / "background", fs::copy_options::recursive);
  copy_mattes(take, part, range);
  TakeInfo info = read_take_info(part);
  info.recorded = take.info().recorded;
  write_take_info(part, info);
  workplace.keep_as(part, options.folder);
  return read_take_info(options.folder);
}

}  // namespace rotunda::capture
