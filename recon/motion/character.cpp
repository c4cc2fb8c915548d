#include "recon/motion/character.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "config/errors.h"
#include "recon/motion/clip_source.h"
#include "recon/motion/graph_builder.h"
#include "recon/motion/graph_file.h"

namespace rotunda::recon {
namespace {

namespace fs = std::filesystem;

// A folder that is whole when it takes its name; dropped before that, nothing is left.
class FolderInTheMaking {
 public:
  explicit FolderInTheMaking(const fs::path& folder)
      : folder_(folder), part_(folder.parent_path() / ("." + folder.filename().string() + ".part")) {
    fs::remove_all(part_);
    fs::create_directories(part_);
  }
  ~FolderInTheMaking() {
    std::error_code ignored;
    fs::remove_all(part_, ignored);
  }
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;
  const fs::path& path() const { return part_; }
  void finish() {
    fs::remove_all(folder_);  // an older character of that name
    fs::rename(part_, folder_);
  }

 private:
  fs::path folder_, part_;
};

void check_takes(const std::vector<CharacterTake>& takes, const fs::path& folder) {
  if (takes.empty()) throw InvalidInput("a character is made of takes; name at least one");
  std::set<std::string> names;
  for (const auto& take : takes)
    if (!names.insert(take.name).second)
      throw InvalidInput(fmt::format("two takes are called {}; name them on the command line: NAME=TAKE", take.name));
  for (const auto& take : takes)
    if (!take.rig.empty() && !takes.front().rig.empty() && take.rig != takes.front().rig)
      throw InvalidInput(
          fmt::format("{} was recorded with rig {}, {} with {}: their colours and scales may differ; build "
                      "a character of one rig's takes",
                      takes.front().take, takes.front().rig, take.take, take.rig));
  if (fs::exists(folder) && !is_character(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
    throw InvalidInput(folder.string() + " is there already and no character; name another folder with -o");
}

void check_rates(const std::vector<ClipSource>& sources) {
  for (const auto& source : sources) {
    if (std::abs(source.header().fps - sources.front().header().fps) > 1e-6)
      throw InvalidInput(fmt::format(
          "{} has {} frames a second, {} has {}: takes of different rigs cannot be one "
          "character",
          sources.front().take().take, sources.front().header().fps, source.take().take, source.header().fps));
    constexpr int kLeast = 3 * kBlendFrames;
    if (source.frame_count() < kLeast)
      throw InvalidInput(fmt::format("{} is too short: {} frames; a clip needs at least {}", source.take().take,
                                     source.frame_count(), kLeast));
  }
}

void stop_if_asked(const CharacterOptions& options) {
  if (options.stop.stop_requested())
    throw std::system_error(std::make_error_code(std::errc::operation_canceled), "stopped");
}

void tell(const CharacterOptions& options, const std::string& what, std::size_t done, std::size_t total) {
  stop_if_asked(options);
  if (options.progress) options.progress(what, done, total);
}

struct RecordedTakes {
  std::vector<ClipSource> sources;
  std::vector<ClipShape> shapes;
};

RecordedTakes read_takes(const std::vector<CharacterTake>& takes, const CharacterOptions& options) {
  RecordedTakes recorded;
  for (const auto& take : takes) recorded.sources.emplace_back(take);
  check_rates(recorded.sources);
  for (auto& source : recorded.sources) {
    tell(options, "reading " + source.take().name, recorded.shapes.size(), takes.size());
    recorded.shapes.push_back(source.shape());
  }
  return recorded;
}

void cut_jumps(RecordedTakes& recorded, CharacterReport& report) {
  for (std::size_t i = 0; i < recorded.sources.size(); ++i) {
    auto& source = recorded.sources[i];
    source.cut_jumps(recorded.shapes[i]);
    if (source.frame_count() < source.header().frame_count())
      report.told.push_back(
          fmt::format("{} jumps: only its frames {}:{} are used", source.take().take, source.first(), source.end()));
  }
  check_rates(recorded.sources);
}

void write_clip(ClipSource& source, const GaitEvents& events, const fs::path& file) {
  std::vector<GeometryImage> images;
  GeometryVideoHeader header;
  MeanSurface mean;
  header.fps = source.header().fps;
  header.first_frame = source.header().first_frame + source.first();
  for (int frame = 0; frame < source.frame_count(); ++frame) {
    auto image = source.read(frame);
    image.normals = {};  // not stored
    const Eigen::Vector2f way = (-events.floor_velocity * (frame / header.fps)).cast<float>();
    for (auto& position : image.positions) position.head<2>() += way;
    add_frame(header, image, source.header().statuses[static_cast<std::size_t>(source.first() + frame)]);
    mean.add(image.positions, header.root_path.back());
    images.push_back(std::move(image));
  }
  GeometryVideoWriter writer(file, header, mean);
  for (const auto& image : images) writer.write(image);
  writer.finish();
}

GeometryVideoReader open_clip(const fs::path& folder, const MotionGraph& graph, const MotionClip& clip) {
  const auto file = clip_video_of(folder, clip.name);
  if (!fs::exists(file))
    throw InvalidInput(fmt::format("{} is missing; clip {} of {} needs it: build the character again", file.string(),
                                   clip.name, graph_of(folder).string()));
  GeometryVideoReader video(file);
  if (video.frame_count() != clip.frames || std::abs(video.header().fps - graph.fps) > 1e-6)
    throw InvalidInput(fmt::format(
        "{} has {} frames at {} Hz, {} says {} at {}: the file was exchanged or cut short; "
        "build the character again",
        file.string(), video.frame_count(), video.header().fps, graph_of(folder).string(), clip.frames, graph.fps));
  return video;
}

MovingClip moving_clip_of(const fs::path& folder, const MotionGraph& graph, const MotionClip& clip) {
  auto video = open_clip(folder, graph, clip);
  return moving_clip(clip_shape(video, clip.name));
}

}  // namespace

fs::path graph_of(const fs::path& character) {
  return character / "graph.yaml";
}

fs::path clip_video_of(const fs::path& character, const std::string& clip) {
  return character / (clip + ".mkv");
}

bool is_character(const fs::path& folder) {
  std::error_code none;
  return fs::is_regular_file(graph_of(folder), none);
}

CharacterReport build_character(const std::vector<CharacterTake>& takes, const fs::path& folder,
                                const CharacterOptions& options) {
  check_takes(takes, folder);
  FolderInTheMaking making(folder);
  CharacterReport report;
  auto recorded = read_takes(takes, options);
  check_people(recorded.sources, recorded.shapes);
  check_lattices(recorded.sources, recorded.shapes);
  cut_jumps(recorded, report);
  tell(options, "joining", 0, takes.size());
  std::vector<MovingClip> clips;
  for (auto& shape : recorded.shapes) clips.push_back(moving_clip(std::move(shape)));
  auto built = build_graph(clips, options.name, options.blend);
  for (std::size_t i = 0; i < takes.size(); ++i) {
    built.graph.clips[i].take = takes[i].take;
    tell(options, "writing " + takes[i].name, i, takes.size());
    write_clip(recorded.sources[i], clips[i].events, clip_video_of(making.path(), takes[i].name));
  }
  write_graph(graph_of(making.path()), built.graph);
  making.finish();
  report.graph = std::move(built.graph);
  report.told.insert(report.told.end(), built.told.begin(), built.told.end());
  return report;
}

MotionGraph open_character(const fs::path& folder) {
  auto graph = read_graph(graph_of(folder));
  for (const auto& clip : graph.clips) {
    auto video = open_clip(folder, graph, clip);
    video.read_in_place(clip.frames - 1, 1);  // a file cut short has its header and no end
  }
  return graph;
}

MotionGraph mend_character(const fs::path& folder) {
  auto graph = open_character(folder);
  std::vector<MovingClip> clips;
  for (const auto& clip : graph.clips) clips.push_back(moving_clip_of(folder, graph, clip));
  const auto named = [&](const std::string& name) -> const MovingClip& {
    return *std::find_if(clips.begin(), clips.end(), [&](const auto& clip) { return clip.shape.name == name; });
  };
  const auto mend = [&](Join& join, const std::string& from, const std::string& to) {
    join = make_join(named(from), named(to), join.leave, join.enter, join.blend);
  };
  for (auto& state : graph.states) mend(state.loop, state.clip, state.clip);
  for (auto& transition : graph.transitions) {
    const auto from = graph.state(transition.from).clip, to = graph.state(transition.to).clip;
    for (auto& leave : transition.leaves) mend(leave, from, transition.synthesised() ? to : transition.clip);
    if (!transition.synthesised()) mend(transition.arrive, transition.clip, to);
  }
  write_graph(graph_of(folder), graph);
  return graph;
}

}  // namespace rotunda::recon
