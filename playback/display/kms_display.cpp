#include "playback/display/kms_display.h"

#include <GLES3/gl3.h>
#include <fmt/format.h>
#include <poll.h>
#include <xf86drm.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>

#include "config/errors.h"
#include "playback/display/context_reset.h"
#include "playback/display/kms_card.h"
#include "playback/display/kms_mode_setter.h"
#include "playback/display/kms_surface.h"
#include "playback/display/seat_input.h"
#include "playback/display/vt_console.h"

namespace rotunda::playback {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLook = std::chrono::seconds(1);  // at the connector: was it unplugged or replaced?
constexpr int kFlipPatience_ms = 1000;           // many refreshes: no driver takes so long unless the display is gone

struct Chosen {
  ConnectorFacts connector;
  KmsPath path;
};

Chosen choose(const KmsCard& card, const std::string& wanted) {
  const auto connectors = card.connectors(false);
  const auto connector = choose_connector(connectors, wanted);
  const auto place = connector ? choose_crtc(*connector, connectors, card.crtcs()) : std::nullopt;
  if (!place) throw DeviceError(card.path().string(), "no CRTC can feed the display; unplug another one");
  return {*connector, {.connector = connector->id, .crtc = card.crtcs()[*place], .crtc_place = *place}};
}

}  // namespace

// Members in the order in which they are made; they go in the opposite one, the text console last.
class KmsDisplay::Screen {
 public:
  explicit Screen(const KmsOptions& options)
      : tell_(options.tell),
        console_(input_.has_keyboard()),
        card_(open_card(options.device, options.connector)),
        chosen_(choose(card_, options.connector)),
        before_(card_, chosen_.path),
        surface_(card_.fd()),
        setter_(options.atomic ? make_atomic_setter(card_, chosen_.path) : nullptr) {
    if (!setter_) setter_ = make_legacy_setter(card_, chosen_.path);
    start(chosen_.connector);
    tell_(fmt::format("{} ({}), {}: {} x {}, {} mode setting, drawn by {}{}", card_.path().string(), card_.driver(),
                      chosen_.connector.name, mode_.hdisplay, mode_.vdisplay, setter_->name(), surface_.renderer(),
                      input_.has_keyboard() ? "" : "; no keyboard (group input may read it)"));
  }

  ~Screen() {
    wait_for_flip();
    before_.restore();
  }

  int width() const { return lit_ ? mode_.hdisplay : 0; }
  int height() const { return lit_ ? mode_.vdisplay : 0; }
  SeatInput& input() { return input_; }

  void present() {
    wait_for_flip();
    if (lit_) flip();
    if (reset_->happened()) throw ContextLost();
    input_.read(mode_.vdisplay);
    look_at_connector();
  }

  void wait(double seconds) {
    const auto patience = std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
    std::array<pollfd, 2> sources = {pollfd{.fd = input_.fd(), .events = POLLIN, .revents = 0},
                                     pollfd{.fd = card_.fd(), .events = POLLIN, .revents = 0}};
    ::poll(sources.data(), sources.size(), static_cast<int>(patience.count()));
    if (sources[1].revents != 0) take_flips();
    input_.read(mode_.vdisplay);
    look_at_connector();
  }

 private:
  void flip() {
    const auto picture = surface_.finish_picture();
    flipping_ = setter_->flip(picture, this);
    if (flipping_) return;
    const std::string reason = std::strerror(errno);
    surface_.dropped();
    go_dark(reason);
  }

  static void on_flip(int, unsigned, unsigned, unsigned, unsigned, void* screen) {
    static_cast<Screen*>(screen)->flipping_ = false;
    static_cast<Screen*>(screen)->surface_.shown();
  }

  void take_flips() {
    drmEventContext events{};
    events.version = 3;
    events.page_flip_handler2 = on_flip;
    drmHandleEvent(card_.fd(), &events);
  }

  void wait_for_flip() {
    while (flipping_) {
      pollfd source{.fd = card_.fd(), .events = POLLIN, .revents = 0};
      const int ready = ::poll(&source, 1, kFlipPatience_ms);
      if (ready < 0 && errno == EINTR) continue;
      if (ready > 0) {
        take_flips();
        continue;
      }
      flipping_ = false;
      return go_dark("it shows no more pictures");
    }
  }

  // In the mode the display prefers, black. False: the driver refuses.
  bool light(const ConnectorFacts& connector) {
    const auto mode = choose_mode(connector.modes);
    if (!mode) return false;
    mode_ = *mode;
    surface_.resize(mode_.hdisplay, mode_.vdisplay);
    reset_.emplace();
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
    glClear(GL_COLOR_BUFFER_BIT);
    lit_ = setter_->light(mode_, surface_.finish_picture());
    lit_ ? surface_.shown() : surface_.dropped();
    looked_at_ = Clock::now();
    return lit_;
  }

  void start(const ConnectorFacts& connector) {
    if (light(connector)) return;
    setter_ = make_legacy_setter(card_, chosen_.path);
    if (light(connector)) return;
    throw DeviceError(card_.path().string(), fmt::format("{} takes no {} x {} picture ({})", connector.name,
                                                         mode_.hdisplay, mode_.vdisplay, std::strerror(errno)));
  }

  void go_dark(const std::string& reason) {
    if (!lit_) return;
    tell_(fmt::format("{}: {}; waiting for it", chosen_.connector.name, reason));
    setter_->darken();
    lit_ = false;
  }

  void look_at_connector() {
    if (Clock::now() - looked_at_ < kLook) return;
    looked_at_ = Clock::now();
    const auto connectors = card_.connectors(!lit_);
    const auto now = choose_connector(connectors, chosen_.connector.name);
    const bool there = now && now->connected && !now->modes.empty();
    if (lit_ && !there) {
      wait_for_flip();
      go_dark("the display is unplugged");
    } else if (lit_ && (now->link_bad || !same_mode(*choose_mode(now->modes), mode_))) {
      wait_for_flip();
      go_dark("the display was replaced");
    }
    if (!lit_ && there && card_.become_master() && light(*now))
      tell_(fmt::format("{}: {} x {} again", now->name, mode_.hdisplay, mode_.vdisplay));
  }

  std::function<void(const std::string&)> tell_;
  SeatInput input_;
  VtConsole console_;
  KmsCard card_;
  Chosen chosen_;
  CrtcBefore before_;
  KmsSurface surface_;
  std::unique_ptr<ModeSetter> setter_;
  std::optional<ContextReset> reset_;
  drmModeModeInfo mode_{};
  bool lit_ = false, flipping_ = false;
  Clock::time_point looked_at_;
};

KmsDisplay::KmsDisplay(const KmsOptions& options) : screen_(std::make_unique<Screen>(options)) {}

KmsDisplay::~KmsDisplay() = default;

int KmsDisplay::width() const {
  return screen_->width();
}

int KmsDisplay::height() const {
  return screen_->height();
}

void KmsDisplay::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width(), height());
}

void KmsDisplay::present() {
  screen_->present();
}

void KmsDisplay::wait_for_input(double seconds) {
  screen_->wait(seconds);
}

WindowInput KmsDisplay::take_input() {
  return screen_->input().take();
}

}  // namespace rotunda::playback
