#pragma once
// A whole screen without a desktop: one connector of a graphics device (KMS), pictures flipped at its refresh. A
// display that is unplugged is waited for and set up anew when it comes back; the text console is given back at the
// end, however that comes. Throws DeviceError, with what to do, if there is nothing to show pictures on.
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "playback/display/display.h"

namespace rotunda::playback {

struct KmsOptions {
  std::filesystem::path device;  // /dev/dri/cardN; empty: the first with a display
  std::string connector;         // "HDMI-A-1"; empty: the first with a display
  bool atomic = true;            // if the driver can; else by the older calls
  std::function<void(const std::string&)> tell = [](const std::string&) {};  // what it shows on, what came and went
};

class KmsDisplay final : public Display {
 public:
  explicit KmsDisplay(const KmsOptions& options = {});
  ~KmsDisplay() override;

  bool is_open() const override { return true; }
  int width() const override;  // 0 while the display is unplugged
  int height() const override;
  void bind() const override;
  void present() override;  // returns when the picture before it is seen
  void wait_for_input(double seconds) override;
  WindowInput take_input() override;

 private:
  class Screen;
  std::unique_ptr<Screen> screen_;
};

}  // namespace rotunda::playback
