#include "playback/player.h"

#include <algorithm>
#include <optional>

#include "playback/display/open_display.h"
#include "playback/frame_fetcher.h"
#include "playback/performer_place.h"
#include "playback/picture_clock.h"
#include "playback/render/overlay.h"
#include "playback/take_desk.h"
#include "playback/take_view.h"

namespace rotunda::playback {
namespace {

// Brings frames onto the view as they are made.
class Projector {
 public:
  // Counts in `frames_shown`.
  Projector(recon::GeometryVideoReader& video, const PlayOptions& options, long& frames_shown)
      : frames_shown_(frames_shown),
        aligned_(video.header().aligned),
        frames_(video.frame_count()),
        fetcher_(video, {.level = options.level}) {
    if (options.pictures)
      pictures_.emplace(options.pictures, static_cast<std::size_t>(video.header().first_frame), frames_);
    view_.show(*fetcher_.wait_for(0));
    ++frames_shown_;
  }

  TakeView& view() { return view_; }
  double shown() const { return shown_; }  // frames from 0; between them a fraction

  // False if it is not made yet: then the view stays as it was.
  bool show(double at, bool in_pictures) {
    const int frame = static_cast<int>(at);
    const double place = aligned_ && !in_pictures ? at : frame;
    if (place == shown_ && in_pictures == in_pictures_) return true;
    const auto image = fetcher_.ready(frame);
    const auto views = in_pictures ? pictures_->ready(frame) : nullptr;
    if (!image || (in_pictures && !views)) return false;
    if (in_pictures)
      view_.show(*image, *views);
    else
      show_between(*image, frame, place - frame);
    frames_shown_ += frame != static_cast<int>(shown_);
    shown_ = place;
    in_pictures_ = in_pictures;
    return true;
  }

 private:
  void show_between(const recon::GeometryImage& image, int frame, double share) {
    const auto next = share > 0.0 && frame + 1 < frames_ ? fetcher_.kept(frame + 1) : nullptr;
    if (next)
      view_.show_between({image, frame}, {*next, frame + 1}, share);
    else
      view_.show_between({image, frame}, {image, frame}, 0.0);
  }

  long& frames_shown_;
  const bool aligned_;
  const int frames_;
  FrameFetcher fetcher_;
  std::optional<PictureFetcher> pictures_;
  TakeView view_;
  double shown_ = 0.0;
  bool in_pictures_ = false;
};

}  // namespace

PlayReport play(recon::GeometryVideoReader& video, const PlayOptions& options) {
  const recon::GeometryVideoHeader& header = video.header();
  const FrameRange all{0, header.frame_count()};
  TakeDesk desk({.frames = all.count(),
                 .first_frame = static_cast<int>(header.first_frame),
                 .fps = header.fps,
                 .has_pictures = options.pictures != nullptr},
                orbit_around(header.box));
  PlayReport report;
  PictureClock clock;
  const auto play_in = [&](Display& window) {
    Projector projector(video, options, report.frames);
    Overlay overlay;
    while (window.is_open() && !desk.ended() && !options.stop.stop_requested() &&
           (options.picture_limit == 0 || report.pictures < options.picture_limit)) {
      const double passed = clock.begin();
      desk.go_on(passed);
      if (!projector.show(desk.at(), desk.shows_pictures())) {
        if (desk.shows_pictures()) desk.wait();
        ++report.late;
      }
      if (window.width() > 0 && window.height() > 0) {
        const auto performer = performer_place(performer_path(header), all, projector.shown());
        desk.look_at(performer);
        window.bind();
        projector.view().draw(desk.orbit().viewpoint(window.width(), window.height()), performer, desk.draw(),
                              clock.coarser());
        overlay.draw(text_card(desk.lines(clock.told())), 12, 12, window.width(), window.height());
      }
      window.present();
      ++report.pictures;
      desk.apply(window.take_input(), passed);
      clock.end(!desk.shows_pictures());
    }
  };
  report.lost_contexts = with_display({.window = {.title = "rotunda",
                                                  .width = options.width,
                                                  .height = options.height,
                                                  .fullscreen = options.fullscreen}},
                                      play_in);
  report.seconds = clock.seconds();
  return report;
}

}  // namespace rotunda::playback
