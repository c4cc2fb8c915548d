// A whole screen without a desktop, on two kinds of graphics device: what QEMU shows of it, against the headless
// picture.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/fb.h>
#include <linux/kd.h>
#include <sys/ioctl.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "config/errors.h"
#include "config/exit_code.h"
#include "kms_show.h"
#include "playback/display/kms_display.h"
#include "qemu_monitor.h"

namespace rotunda::vm {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

struct Graphics {
  std::string driver;
  std::string qemu;  // its name there
  int number;        // of /dev/dri/cardN and /dev/fbN: in the order of the modules
  std::string setting;

  std::string card() const { return "/dev/dri/card" + std::to_string(number); }
  // As if its display were unplugged and plugged in.
  void set_connector(const std::string& state) const {
    const auto name = "card" + std::to_string(number) + "-Virtual-" + std::to_string(number + 1);
    std::ofstream("/sys/class/drm/" + name + "/status") << state;
  }
};

void PrintTo(const Graphics& graphics, std::ostream* out) {
  *out << graphics.driver << ", " << graphics.setting;
}

const Graphics kBochs{"bochs-drm", "gpu0", 0, "atomic"};
const Graphics kVirtio{"virtio_gpu", "gpu1", 1, "atomic"};

void write_to(const char* file, const std::string& text) {
  std::ofstream(file) << text << std::flush;
}

int console_mode() {
  const capture::UniqueFd console(::open("/dev/tty1", O_RDWR | O_NOCTTY | O_CLOEXEC));
  int mode = -1;
  ::ioctl(console.get(), KDGETMODE, &mode);
  return mode;
}

// There is no udev daemon here: its note on the one keyboard, as libinput wants it.
void tag_keyboard() {
  std::filesystem::create_directories("/run/udev/data");
  write_to("/run/udev/data/c13:64", "I:1\nE:ID_INPUT=1\nE:ID_INPUT_KEY=1\nE:ID_INPUT_KEYBOARD=1\nV:1\n");
}

class WholeScreen : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    tag_keyboard();
    write_to("/dev/tty1", "\033[?25l\033[2J\033[Hthe console\n");  // without a blinking cursor
  }

  // The text console on this device's screen; it is written there in the kernel's own time.
  cv::Mat console_on(const Graphics& graphics) {
    const capture::UniqueFd framebuffer(::open("/dev/fb0", O_RDWR | O_CLOEXEC));
    fb_con2fbmap map{.console = 1, .framebuffer = static_cast<__u32>(graphics.number)};
    EXPECT_EQ(::ioctl(framebuffer.get(), FBIOPUT_CON2FBMAP, &map), 0);
    cv::Mat before, console;
    for (const auto end = std::chrono::steady_clock::now() + 20s; std::chrono::steady_clock::now() < end;) {
      std::this_thread::sleep_for(500ms);
      before = std::exchange(console, monitor_.screen(graphics.qemu));
      const bool still = before.size() == console.size() && cv::norm(before, console, cv::NORM_INF) == 0.0;
      if (still && cv::norm(console, cv::NORM_INF) > 100.0) return console;
    }
    ADD_FAILURE() << "no text on the screen of " << graphics.driver;
    return console;
  }

  // Within 20 s, to a level of 255.
  testing::AssertionResult shows(const Graphics& graphics, const cv::Mat& wanted) {
    std::string last = "nothing";
    for (const auto end = std::chrono::steady_clock::now() + 20s; std::chrono::steady_clock::now() < end;) {
      const auto seen = monitor_.screen(graphics.qemu);
      if (seen.size() != wanted.size()) {
        last = "a picture of " + std::to_string(seen.cols) + " x " + std::to_string(seen.rows);
      } else if (const double off = cv::norm(seen, wanted, cv::NORM_INF); off > 1.0) {
        last = "a picture that is off by up to " + std::to_string(off);
      } else {
        return testing::AssertionSuccess();
      }
      std::this_thread::sleep_for(200ms);
    }
    return testing::AssertionFailure() << graphics.driver << " shows " << last;
  }

  QemuMonitor monitor_;
};

class EveryDevice : public WholeScreen, public testing::WithParamInterface<Graphics> {};

TEST_P(EveryDevice, ShowsTheHeadlessPictureAndGivesTheConsoleBack) {
  const auto& graphics = GetParam();
  const cv::Size size = graphics.number == 0 ? cv::Size(640, 480) : cv::Size(800, 600);  // as QEMU's displays prefer
  const auto wanted = headless_picture(size);
  const auto console = console_on(graphics);
  ShowProcess show({graphics.card(), graphics.setting});
  ASSERT_TRUE(show.told("drawn by")) << show.output();
  EXPECT_THAT(show.output(), HasSubstr("(" + graphics.driver + ")"));
  EXPECT_THAT(show.output(), HasSubstr(graphics.setting + " mode setting"));
  ASSERT_TRUE(show.told(kManyPictures)) << show.output();
  EXPECT_TRUE(shows(graphics, wanted));
  EXPECT_EQ(console_mode(), KD_GRAPHICS);

  show.send(SIGTERM);
  EXPECT_EQ(show.wait(), 0) << show.output();
  EXPECT_EQ(console_mode(), KD_TEXT);
  EXPECT_TRUE(shows(graphics, console));
}

INSTANTIATE_TEST_SUITE_P(WholeScreen, EveryDevice,
                         testing::Values(kBochs, Graphics{"bochs-drm", "gpu0", 0, "legacy"}, kVirtio,
                                         Graphics{"virtio_gpu", "gpu1", 1, "legacy"}),
                         [](const auto& one) { return one.param.qemu + one.param.setting; });

const cv::Size kSize(640, 480);  // of the first device

std::string why_not(const playback::KmsOptions& options) {
  try {
    playback::KmsDisplay display(options);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "nothing";
}

TEST_F(WholeScreen, GivesTheConsoleBackHoweverItEnds) {
  const auto wanted = headless_picture(kSize);
  const auto console = console_on(kBochs);
  for (const bool killed : {true, false}) {
    ShowProcess show({kBochs.card(), "atomic"});
    ASSERT_TRUE(show.told("drawn by")) << show.output();
    EXPECT_TRUE(shows(kBochs, wanted));
    EXPECT_EQ(console_mode(), KD_GRAPHICS);
    show.send(killed ? SIGKILL : SIGUSR1);
    EXPECT_EQ(show.wait(), killed ? 128 + SIGKILL : kBadInput) << show.output();
    EXPECT_TRUE(shows(kBochs, console));
    EXPECT_EQ(console_mode(), KD_TEXT);
  }
}

TEST_F(WholeScreen, WaitsForADisplayThatIsUnplugged) {
  const auto wanted = headless_picture(kSize);
  for (const auto& setting : {"atomic", "legacy"}) {
    ShowProcess show({kBochs.card(), setting});
    ASSERT_TRUE(shows(kBochs, wanted)) << show.output();
    kBochs.set_connector("off");
    ASSERT_TRUE(show.told("unplugged; waiting")) << show.output();
    kBochs.set_connector("detect");
    ASSERT_TRUE(show.told("640 x 480 again")) << show.output();
    EXPECT_TRUE(shows(kBochs, wanted));
    show.send(SIGTERM);
    EXPECT_EQ(show.wait(), 0) << show.output();
  }
}

TEST_F(WholeScreen, EndsOnRequestWhileTheDisplayIsUnplugged) {
  const auto console = console_on(kBochs);
  ShowProcess show({kBochs.card(), "atomic"});
  ASSERT_TRUE(show.told("drawn by")) << show.output();
  kBochs.set_connector("off");
  ASSERT_TRUE(show.told("unplugged; waiting")) << show.output();
  show.send(SIGTERM);
  EXPECT_EQ(show.wait(), 0) << show.output();
  kBochs.set_connector("detect");
  EXPECT_EQ(console_mode(), KD_TEXT);
}

TEST_F(WholeScreen, IsSteeredByTheKeyboard) {
  const auto colour = headless_picture(kSize), grey = headless_picture(kSize, "grey");
  ShowProcess show({kBochs.card(), "atomic"});
  ASSERT_TRUE(show.told("drawn by")) << show.output();
  EXPECT_THAT(show.output(), testing::Not(HasSubstr("no keyboard")));
  EXPECT_TRUE(shows(kBochs, colour));
  monitor_.press("g");
  EXPECT_TRUE(shows(kBochs, grey));
  monitor_.press("q");
  EXPECT_EQ(show.wait(), 0) << show.output();
}

TEST_F(WholeScreen, IsTheKiosksWithoutADesktop) {
  ShowProcess kiosk({"/tmp/no-daemon.sock"}, "--daemon", ROTUNDA_BINARY_DIR "/rotunda-kiosk");
  EXPECT_TRUE(kiosk.told("/dev/dri/card0 (bochs-drm), Virtual-1: 640 x 480, atomic")) << kiosk.output();
  monitor_.press("q");
  EXPECT_EQ(kiosk.wait(), 0) << kiosk.output();
}

TEST_F(WholeScreen, TakesTheFirstDeviceWithADisplayOrSaysWhyThereIsNone) {
  kBochs.set_connector("off");
  {
    ShowProcess show({"", "atomic"});
    EXPECT_TRUE(show.told("/dev/dri/card1 (virtio_gpu), Virtual-2")) << show.output();
    EXPECT_THAT(why_not({.device = kVirtio.card()}), HasSubstr("another program shows something on it"));
  }
  kVirtio.set_connector("off");
  EXPECT_THAT(why_not({}), AllOf(HasSubstr("card0: no display is connected"), HasSubstr("card1: no display")));
  EXPECT_THAT(why_not({.device = kBochs.card(), .connector = "HDMI-A-1"}),
              HasSubstr("no display at connector HDMI-A-1; connect and switch on a display (connectors: Virtual-1"));
  EXPECT_THAT(why_not({.device = "/dev/dri/card7"}), HasSubstr("`ls /dev/dri`"));
  ASSERT_EQ(::seteuid(65534), 0);
  const auto as_nobody = why_not({.device = kBochs.card()});
  ASSERT_EQ(::seteuid(0), 0);
  EXPECT_THAT(as_nobody, HasSubstr("group video"));
  kBochs.set_connector("detect");
  kVirtio.set_connector("detect");
}

}  // namespace
}  // namespace rotunda::vm
