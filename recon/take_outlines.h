#pragma once
// A take's silhouettes for motion capture: by the live key where a plate shows the screen, else by the full key; mattes
// that came with the take stay.
#include <filesystem>
#include <optional>

#include "capture/take/take_reader.h"
#include "recon/body/outline_source.h"
#include "recon/take_studio.h"

namespace rotunda::recon {

class TakeOutlines final : public OutlineSource {
 public:
  // Learns missing plates from the take. Throws InvalidInput (fewer than two cameras), ConfigError, CorruptData,
  // std::system_error.
  TakeOutlines(const std::filesystem::path& take, const std::optional<std::filesystem::path>& calibration);

  std::string name() const override { return "take " + take_.info().name; }
  std::string where_to_look() const override;
  std::size_t frame_count() const override { return take_.frame_set_count(); }
  double fps() const override { return take_.info().fps; }
  FrameOutlines outlines(std::size_t frame) override;

 private:
  FrameViews keyed(std::size_t frame);

  capture::TakeReader take_;
  TakeStudio studio_;
};

}  // namespace rotunda::recon
