#include "capture/take/take_export.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <system_error>

#include "capture/picture.h"
#include "capture/take/take_reader.h"

namespace rotunda::capture {

TakeExportResult export_take(const TakeReader& take, const std::filesystem::path& folder, const Progress& progress,
                             std::stop_token stop) {
  const auto& cameras = take.info().cameras;
  for (const auto& camera : cameras) std::filesystem::create_directories(folder / camera.name);
  std::atomic<std::size_t> written = 0;
  for (std::size_t index = 0; index < take.frame_set_count(); ++index) {
    if (stop.stop_requested())
      throw std::system_error(std::make_error_code(std::errc::operation_canceled), "exporting " + take.info().name);
    tbb::parallel_for(std::size_t{0}, cameras.size(), [&](std::size_t camera) {
      const SlotPicture picture = picture_of(take.read(index, camera));
      if (picture.rgb.empty()) return;
      write_png(folder / cameras[camera].name / frame_file_name(index), picture.rgb);
      ++written;
    });
    if (progress) progress(index + 1, take.frame_set_count());
  }
  return {.written = written, .missing = take.frame_set_count() * cameras.size() - written};
}

}  // namespace rotunda::capture
