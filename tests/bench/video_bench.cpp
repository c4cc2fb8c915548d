// What a geometry video's profiles cost and lose, beside Draco frame by frame, on frames of a real reconstruction:
//   video_bench CLIP.mkv [FRAMES]
// Rates are of the whole second, by stream; the mean image of a stream counts apart, for it is sent once. Errors are
// distances of samples from the clip's own; what its 16 bits rounded away is put back as noise of half a step, so that
// no profile profits from finding numbers rounded already. Decoding is from the file to what the GPU takes, one thread,
// CPU; its baseline is the same streams through FFmpeg alone (nothing checked, nothing kept).
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <nanoflann.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "capture/base/av_objects.h"
#include "recon/export/clip_export.h"
#include "recon/sphere/octahedral_lattice.h"
#include "recon/video/geometry_video.h"
#include "recon/video/paper_video.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

namespace {

using namespace rotunda;
namespace fs = std::filesystem;
using Positions = std::vector<Eigen::Vector3f>;

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Error {
  double rms = 0.0, p99 = 0.0, max = 0.0;  // mm
};

Error error_of(std::vector<double> distances) {
  std::sort(distances.begin(), distances.end());
  double squares = 0.0;
  for (const double d : distances) squares += d * d;
  const auto count = static_cast<double>(distances.size());
  return {1e3 * std::sqrt(squares / count), 1e3 * distances[static_cast<std::size_t>(0.99 * (count - 1.0))],
          1e3 * distances.back()};
}

// Peak signal to noise of the luma of BT.601, dB.
class LumaError {
 public:
  void add(const std::vector<recon::Colour>& read, const std::vector<recon::Colour>& meant) {
    if (read.size() != meant.size()) return;  // at another level
    for (std::size_t i = 0; i < read.size(); ++i) {
      const double error = luma(read[i]) - luma(meant[i]);
      squares_ += error * error;
    }
    count_ += static_cast<double>(read.size());
  }
  std::string text() const {
    if (count_ == 0.0) return "";
    return squares_ > 0.0 ? fmt::format(", luma {:.1f} dB", 10.0 * std::log10(255.0 * 255.0 * count_ / squares_))
                          : ", colours exact";
  }

 private:
  static double luma(const recon::Colour& c) { return 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2]; }
  double squares_ = 0.0, count_ = 0.0;
};

void print(const std::string& name, const std::string& rates, const Error& error, double decode_ms,
           const std::string& baseline) {
  fmt::print("{:<26} {:<62} rms {:6.3f} p99 {:6.2f} max {:6.1f} mm  decode {:5.2f} ms CPU{}\n", name, rates, error.rms,
             error.p99, error.max, decode_ms, baseline);
}

// The clip's frames with the rounding of its 16 bits made noise.
std::vector<recon::GeometryImage> frames_of(const fs::path& clip, int most) {
  recon::GeometryVideoReader video(clip);
  std::vector<recon::GeometryImage> frames;
  std::mt19937 random(1);
  const Eigen::Vector3f step = (video.header().box.sizes() / 65535.0).cast<float>();
  std::uniform_real_distribution<float> half(-0.5F, 0.5F);
  for (int i = 0; i < std::min(most, video.frame_count()); ++i) {
    frames.push_back(video.read(i));
    auto& positions = frames.back().positions;
    const int side = frames.back().side();
    for (auto& p : positions) p += Eigen::Vector3f(half(random), half(random), half(random)).cwiseProduct(step);
    for (std::size_t s = 0; s < positions.size(); ++s)  // the border's copies stay one point
      positions[s] = positions[recon::canonical_sample(frames.back().level, static_cast<int>(s) % side,
                                                       static_cast<int>(s) / side)];
  }
  return frames;
}

// Bytes of each video stream's packets, in order.
std::vector<std::size_t> stream_bytes(const fs::path& file) {
  const auto input = capture::open_input(file);
  const auto packet = capture::make_packet();
  std::vector<std::size_t> bytes(input->nb_streams, 0);
  while (av_read_frame(input.get(), packet.get()) >= 0) {
    bytes[static_cast<std::size_t>(packet->stream_index)] += static_cast<std::size_t>(packet->size);
    av_packet_unref(packet.get());
  }
  return bytes;
}

// CPU for a frame of all streams, decoded and thrown away.
double bare_decode_ms(const fs::path& file, int frames) {
  const auto input = capture::open_input(file);
  std::vector<capture::AvCodec> decoders;
  for (unsigned i = 0; i < input->nb_streams; ++i) {
    const auto& parameters = *input->streams[i]->codecpar;
    capture::AvCodec decoder;
    if (parameters.codec_type == AVMEDIA_TYPE_VIDEO) {
      decoder = capture::make_decoder(avcodec_get_name(parameters.codec_id));
      capture::check(avcodec_parameters_to_context(decoder.get(), &parameters), file.string());
      decoder->thread_count = 1;
      capture::check(avcodec_open2(decoder.get(), nullptr, nullptr), file.string());
    }
    decoders.push_back(std::move(decoder));
  }
  const auto packet = capture::make_packet();
  const auto frame = capture::make_frame();
  const double start = cpu_ms();
  while (av_read_frame(input.get(), packet.get()) >= 0) {
    if (auto* decoder = decoders[static_cast<std::size_t>(packet->stream_index)].get()) {
      avcodec_send_packet(decoder, packet.get());
      avcodec_receive_frame(decoder, frame.get());
    }
    av_packet_unref(packet.get());
  }
  return (cpu_ms() - start) / frames;
}

template <class Reader>
void measure_video(const std::string& name, Reader&& read, const fs::path& file,
                   const std::vector<recon::GeometryImage>& frames, double fps) {
  std::vector<double> distances;
  LumaError luma;
  double decoding = 0.0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double start = cpu_ms();
    const auto image = read(static_cast<int>(i));
    decoding += cpu_ms() - start;
    luma.add(image.colours, frames[i].colours);
    for (std::size_t v = 0; v < image.positions.size(); ++v)
      distances.push_back(static_cast<double>((image.positions[v] - frames[i].positions[v]).norm()));
  }
  const double count = static_cast<double>(frames.size());
  const auto bytes = stream_bytes(file);
  const auto rate = [&](std::size_t stream) { return 8e-6 * static_cast<double>(bytes.at(stream)) * fps / count; };
  const bool is_float = name == "float", is_paper = name == "paper";
  const double positions = rate(0) + (is_float ? rate(3) : 0.0), coverage = is_paper ? 0.0 : rate(2);
  const auto rates = fmt::format("{:7.2f} Mbit/s: positions {:6.2f}, colours {:5.2f}, coverage {:4.2f}",
                                 positions + rate(1) + coverage, positions, rate(1), coverage);
  const auto baseline =
      fmt::format(" (FFmpeg alone {:.2f}){}", bare_decode_ms(file, static_cast<int>(frames.size())), luma.text());
  print(name, rates, error_of(std::move(distances)), decoding / count, baseline);
}

void measure_profile(recon::GeometryVideoReader& clip, recon::ClipFormat format, const std::string& name,
                     const fs::path& folder, const std::vector<recon::GeometryImage>& frames) {
  const auto file = folder / (name + (name == "paper" || name == "master, AVI" ? ".avi" : ".mkv"));
  const double start = cpu_ms();
  recon::export_clip(clip, {.format = format, .output = file});
  const double encoding = (cpu_ms() - start) / static_cast<double>(frames.size());
  const double fps = clip.header().fps;
  if (format == recon::ClipFormat::paper) {
    recon::PaperVideoReader video(file, folder / (name + ".json"));
    measure_video(
        name, [&](int i) { return video.read(i); }, file, frames, fps);
  } else {
    recon::GeometryVideoReader video(file);
    measure_video(
        name, [&](int i) { return video.read(i, {.drawn = true}); }, file, frames, fps);
    if (format == recon::ClipFormat::stream) {
      const auto mean = fs::file_size(file);
      std::size_t packets = 0;
      for (const auto bytes : stream_bytes(file)) packets += bytes;
      fmt::print("{:<26} the mean image and headers: {:.0f} kB once\n", "", 1e-3 * static_cast<double>(mean - packets));
    }
  }
  fmt::print("{:<26} exporting {:.1f} ms CPU a frame\n", "", encoding);
}

std::unique_ptr<draco::Mesh> draco_mesh(const Positions& positions,
                                        const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  auto mesh = std::make_unique<draco::Mesh>();
  mesh->set_num_points(static_cast<std::uint32_t>(positions.size()));
  draco::GeometryAttribute attribute;
  attribute.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 3 * sizeof(float), 0);
  const int id = mesh->AddAttribute(attribute, true, static_cast<std::uint32_t>(positions.size()));
  for (std::uint32_t v = 0; v < positions.size(); ++v)
    mesh->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), positions[v].data());
  for (const auto& t : triangles)
    mesh->AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  return mesh;
}

struct PointSet {
  const Positions& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const {
    return points[index][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using PointTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointSet>, PointSet, 3>;

// Draco does not keep the order of vertices: each is compared with the nearest one that was meant.
void add_distances(const Positions& meant, const draco::Mesh& decoded, std::vector<double>& distances) {
  const PointSet set{meant};
  PointTree tree(3, set);
  tree.buildIndex();
  const auto* positions = decoded.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  for (draco::AttributeValueIndex v(0); v < static_cast<std::uint32_t>(positions->size()); ++v) {
    std::array<float, 3> at{};
    positions->GetValue(v, at.data());
    std::uint32_t nearest = 0;
    float squared = 0.0F;
    tree.knnSearch(at.data(), 1, &nearest, &squared);
    distances.push_back(std::sqrt(static_cast<double>(squared)));
  }
}

// Every frame's positions alone, every `stride`-th sample; speeds 3 of 10 as draco_encoder has by itself.
void measure_draco(const std::vector<recon::GeometryImage>& frames, int level, int bits, double fps) {
  const auto lattice = recon::weld_lattice(level);
  const int stride = 1 << (frames[0].level - level), side = recon::lattice_side(level);
  std::size_t bytes = 0;
  double decoding = 0.0;
  std::vector<double> distances;
  for (const auto& frame : frames) {
    Positions welded;
    for (const auto sample : lattice.sample_of_vertex) {
      const auto row = static_cast<int>(sample) / side, column = static_cast<int>(sample) % side;
      welded.push_back(frame.positions[static_cast<std::size_t>(row * stride * frame.side() + column * stride)]);
    }
    const auto mesh = draco_mesh(welded, lattice.triangles);
    draco::Encoder encoder;
    encoder.SetSpeedOptions(3, 3);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
    draco::EncoderBuffer coded;
    if (!encoder.EncodeMeshToBuffer(*mesh, &coded).ok()) throw std::runtime_error("Draco does not take the surface");
    bytes += coded.size();
    draco::DecoderBuffer buffer;
    buffer.Init(coded.data(), coded.size());
    draco::Decoder decoder;
    const double start = cpu_ms();
    const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    decoding += cpu_ms() - start;
    add_distances(welded, *decoded.value(), distances);
  }
  const auto count = static_cast<double>(frames.size());
  print(fmt::format("Draco, {} bits, level {}", bits, level),
        fmt::format("{:7.2f} Mbit/s: positions alone", 8e-6 * static_cast<double>(bytes) * fps / count),
        error_of(std::move(distances)), decoding / count, "");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "video_bench CLIP.mkv [FRAMES]\n");
    return 2;
  }
  const auto frames = frames_of(argv[1], argc > 2 ? std::atoi(argv[2]) : 50);
  recon::GeometryVideoReader original(argv[1]);
  const double fps = original.header().fps;
  const auto folder = fs::temp_directory_path() / fmt::format("video_bench_{}", ::getpid());
  fs::create_directories(folder);
  {
    recon::GeometryVideoHeader header;
    header.fps = fps;
    header.aligned = original.header().aligned;
    header.profile = recon::VideoProfile::float32;
    for (const auto& frame : frames) recon::add_frame(header, frame);
    recon::GeometryVideoWriter writer(folder / "clip.mkv", header);
    for (const auto& frame : frames) writer.write(frame);
    writer.finish();
  }
  recon::GeometryVideoReader clip(folder / "clip.mkv");
  fmt::print("{}: {} frames, level {}, colours {}, {}\n", argv[1], frames.size(), clip.header().level,
             clip.header().colour_level, clip.header().aligned ? "aligned" : "each frame mapped by itself");
  measure_profile(clip, recon::ClipFormat::paper, "paper", folder, frames);
  measure_profile(clip, recon::ClipFormat::float32, "float", folder, frames);
  measure_profile(clip, recon::ClipFormat::master, "master", folder, frames);
  measure_profile(clip, recon::ClipFormat::master, "master, AVI", folder, frames);
  measure_profile(clip, recon::ClipFormat::stream, "stream", folder, frames);
  for (const int level : {clip.header().level, clip.header().level - 1})
    for (const int bits : {11, 12, 14}) measure_draco(frames, level, bits, fps);
  fs::remove_all(folder);
}
