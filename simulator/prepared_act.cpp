#include "simulator/prepared_act.h"

#include "simulator/studio/truth.h"

namespace rotunda::simulator {
namespace {

// Makes performance and renderer when first needed: with a full cache they never are.
class Preparation {
 public:
  explicit Preparation(const ActOptions& options) : options_(options) {
    const auto known = fingerprint_of(options.performance);
    key_ = picture_key(known ? *known : performance().fingerprint(), options.cameras, options.sensor, options.format,
                       options.backdrop);
    if (options.truth)
      truth_.emplace(*options.truth, performance(), options.cameras, performance().frames(), key_.digest,
                     options.sensor);
  }

  std::unique_ptr<ActPlayer> out_of_cache(FrameCache cache) {
    auto entry = entry_in(cache);
    while (!options_.stop.stop_requested()) {
      if (!is_complete(entry) && !render_ahead(renderer(), entry, ahead())) break;
      if (entry.shape().bytes() > options_.most_held_bytes) return stream_from_disk(std::move(entry));
      if (auto frames = entry.read()) return hold_in_memory(std::move(*frames));
      // A damaged frame was removed: render it again.
    }
    return nullptr;
  }

  std::unique_ptr<ActPlayer> out_of_memory() {
    auto frames = render_ahead(renderer(), ahead());
    if (frames.size() != static_cast<std::size_t>(performance().frames())) return nullptr;
    return hold_in_memory(std::move(frames));
  }

 private:
  const Performance& performance() {
    if (!performance_) performance_ = make_performance(options_.performance);
    return *performance_;
  }
  SceneRenderer& renderer() {
    if (!renderer_) renderer_.emplace(performance(), options_.cameras, options_.sensor, options_.backdrop);
    return *renderer_;
  }
  AheadOptions ahead() const {
    return {.format = options_.format,
            .truth = truth_ ? &*truth_ : nullptr,
            .progress = options_.progress,
            .stop = options_.stop};
  }

  CacheEntry entry_in(FrameCache& cache) {
    if (auto found = cache.find(key_)) return std::move(*found);
    return cache.open(key_, shape_of(options_.cameras, performance().frames(), options_.format));
  }

  bool is_complete(const CacheEntry& entry) const {
    if (!entry.missing().empty()) return false;
    for (int frame = 0; truth_ && frame < entry.shape().frames; ++frame)
      if (!truth_->has(frame)) return false;
    return true;
  }

  const ActOptions& options_;
  PictureKey key_;
  std::unique_ptr<Performance> performance_;
  std::optional<TruthFiles> truth_;
  std::optional<SceneRenderer> renderer_;
};

}  // namespace

std::unique_ptr<ActPlayer> prepare_act(const ActOptions& options) {
  Preparation preparation(options);
  return options.cache ? preparation.out_of_cache(FrameCache(*options.cache)) : preparation.out_of_memory();
}

}  // namespace rotunda::simulator
