#include "capture/take/ffv1_picture.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <opencv2/imgproc.hpp>

#include "capture/packed_samples.h"
#include "capture/take/camera_stream.h"
#include "config/errors.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/opt.h>
}

namespace rotunda::capture {
namespace {

// Of the entropy coders of 8-bit samples: Golomb-Rice codes, against the range coder, make quadrants 0.5 % larger and
// half as long in coming (a mosaic as it is would grow by 20 %). Samples of more
// bits have the range coder in any case.
constexpr int kGolombRice = 0;
constexpr int kSlices = 4;  // two by two: a mosaic's quadrants, each with statistics of its own

std::size_t pixels_of(const TakeCamera& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

bool deep(const TakeCamera& camera) {
  return layout_of(camera.format).packing != PixelPacking::bytes;
}

// 8-bit RGB enters FFV1 as blue, green, red, nothing: the one 8-bit RGB layout it codes.
AVPixelFormat picture_format(const TakeCamera& camera) {
  switch (ffv1_layout(camera)) {
    case Ffv1Layout::rgb:
      return AV_PIX_FMT_BGR0;
    case Ffv1Layout::grey:
      return AV_PIX_FMT_GRAY8;
    case Ffv1Layout::quadrants:
      return deep(camera) ? AV_PIX_FMT_GRAY16LE : AV_PIX_FMT_GRAY8;
    case Ffv1Layout::planes:
      return camera.format == PixelFormat::nv12 ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV422P;
    case Ffv1Layout::none:
      break;
  }
  throw InvalidInput(camera.name + ": " + std::string(to_string(camera.format)) + " has no place in FFV1");
}

template <class Sample>
cv::Mat_<Sample> plane(const AVFrame& picture, int index, int width, int height) {
  return cv::Mat_<Sample>(height, width, reinterpret_cast<Sample*>(picture.data[index]),
                          static_cast<std::size_t>(picture.linesize[index]));
}

// const_cast: cv::Mat has no read-only view; it is only read.
template <class Sample>
cv::Mat_<Sample> samples_at(const Sample* samples, const TakeCamera& camera) {
  return cv::Mat_<Sample>(camera.height, camera.width, const_cast<Sample*>(samples));
}

// Where row or column `at` of a mosaic stands in the quadrants.
int in_quadrants(int at, int length) {
  return at % 2 == 0 ? at / 2 : (length + 1) / 2 + at / 2;
}

template <class Sample>
void split(const cv::Mat_<Sample>& mosaic, cv::Mat_<Sample> quadrants) {
  for (int y = 0; y < mosaic.rows; ++y) {
    const Sample* from = mosaic[y];
    Sample* even = quadrants[in_quadrants(y, mosaic.rows)];
    Sample* odd = even + (mosaic.cols + 1) / 2;
    for (int x = 0; x + 1 < mosaic.cols; x += 2) {
      even[x / 2] = from[x];
      odd[x / 2] = from[x + 1];
    }
    if (mosaic.cols % 2 != 0) even[mosaic.cols / 2] = from[mosaic.cols - 1];
  }
}

template <class Sample>
void join(const cv::Mat_<Sample>& quadrants, cv::Mat_<Sample> mosaic) {
  for (int y = 0; y < mosaic.rows; ++y) {
    Sample* to = mosaic[y];
    const Sample* even = quadrants[in_quadrants(y, mosaic.rows)];
    const Sample* odd = even + (mosaic.cols + 1) / 2;
    for (int x = 0; x + 1 < mosaic.cols; x += 2) {
      to[x] = even[x / 2];
      to[x + 1] = odd[x / 2];
    }
    if (mosaic.cols % 2 != 0) to[mosaic.cols - 1] = even[mosaic.cols / 2];
  }
}

// The places of a pixel pair's Y', Cb, Y', Cr in their four bytes.
struct PairOrder {
  int y0, cb, y1, cr;
};
PairOrder pair_order(PixelFormat format) {
  return format == PixelFormat::yuyv ? PairOrder{0, 1, 2, 3} : PairOrder{1, 0, 3, 2};
}

// Calls work(bytes of a pair, its two Y', Cb, Cr) for all of a 4:2:2 image.
template <class Byte, class Work>
void each_pair(Byte* bytes, const AVFrame& picture, const TakeCamera& camera, Work work) {
  auto luma = plane<std::uint8_t>(picture, 0, camera.width, camera.height);
  auto cb = plane<std::uint8_t>(picture, 1, camera.width / 2, camera.height);
  auto cr = plane<std::uint8_t>(picture, 2, camera.width / 2, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int pair = 0; pair < camera.width / 2; ++pair, bytes += 4)
      work(bytes, luma[y] + 2 * pair, cb(y, pair), cr(y, pair));
}

void split_pairs(const std::uint8_t* bytes, const AVFrame& picture, const TakeCamera& camera) {
  each_pair(bytes, picture, camera,
            [at = pair_order(camera.format)](const std::uint8_t* pair, std::uint8_t* luma, std::uint8_t& cb,
                                             std::uint8_t& cr) {
              luma[0] = pair[at.y0];
              luma[1] = pair[at.y1];
              cb = pair[at.cb];
              cr = pair[at.cr];
            });
}

void join_pairs(const AVFrame& picture, std::uint8_t* bytes, const TakeCamera& camera) {
  each_pair(
      bytes, picture, camera,
      [at = pair_order(camera.format)](std::uint8_t* pair, const std::uint8_t* luma, std::uint8_t cb, std::uint8_t cr) {
        pair[at.y0] = luma[0];
        pair[at.y1] = luma[1];
        pair[at.cb] = cb;
        pair[at.cr] = cr;
      });
}

// All Y', then Cb and Cr in turn.
void split_nv12(const std::uint8_t* bytes, const AVFrame& picture, const TakeCamera& camera) {
  samples_at(bytes, camera).copyTo(plane<std::uint8_t>(picture, 0, camera.width, camera.height));
  const cv::Mat_<cv::Vec2b> pairs(camera.height / 2, camera.width / 2,
                                  reinterpret_cast<cv::Vec2b*>(const_cast<std::uint8_t*>(bytes + pixels_of(camera))));
  cv::extractChannel(pairs, plane<std::uint8_t>(picture, 1, pairs.cols, pairs.rows), 0);
  cv::extractChannel(pairs, plane<std::uint8_t>(picture, 2, pairs.cols, pairs.rows), 1);
}

void join_nv12(const AVFrame& picture, std::uint8_t* bytes, const TakeCamera& camera) {
  plane<std::uint8_t>(picture, 0, camera.width, camera.height).copyTo(samples_at(bytes, camera));
  cv::Mat_<cv::Vec2b> pairs(camera.height / 2, camera.width / 2,
                            reinterpret_cast<cv::Vec2b*>(bytes + pixels_of(camera)));
  cv::insertChannel(plane<std::uint8_t>(picture, 1, pairs.cols, pairs.rows), pairs, 0);
  cv::insertChannel(plane<std::uint8_t>(picture, 2, pairs.cols, pairs.rows), pairs, 1);
}

void fill_quadrants(const Image& image, const AVFrame& picture, const TakeCamera& camera) {
  if (!deep(camera))
    return split(samples_at(image.pixels.get(), camera), plane<std::uint8_t>(picture, 0, camera.width, camera.height));
  const auto samples = unpack_samples(image.bytes(), pixels_of(camera), layout_of(camera.format).packing);
  split(samples_at(samples.data(), camera), plane<std::uint16_t>(picture, 0, camera.width, camera.height));
}

std::vector<std::uint8_t> bytes_of_quadrants(const AVFrame& picture, const TakeCamera& camera) {
  if (!deep(camera)) {
    std::vector<std::uint8_t> bytes(pixels_of(camera));
    join(plane<std::uint8_t>(picture, 0, camera.width, camera.height), samples_at<std::uint8_t>(bytes.data(), camera));
    return bytes;
  }
  std::vector<std::uint16_t> samples(pixels_of(camera));
  join(plane<std::uint16_t>(picture, 0, camera.width, camera.height),
       samples_at<std::uint16_t>(samples.data(), camera));
  return pack_samples(samples, layout_of(camera.format).packing);
}

void fill(const Image& image, const AVFrame& picture, const TakeCamera& camera) {
  const std::uint8_t* bytes = image.pixels.get();
  switch (ffv1_layout(camera)) {
    case Ffv1Layout::rgb: {
      const cv::Mat rgb(camera.height, camera.width, CV_8UC3, const_cast<std::uint8_t*>(bytes));
      return cv::cvtColor(rgb, plane<cv::Vec4b>(picture, 0, camera.width, camera.height), cv::COLOR_RGB2BGRA);
    }
    case Ffv1Layout::grey:
      return samples_at(bytes, camera).copyTo(plane<std::uint8_t>(picture, 0, camera.width, camera.height));
    case Ffv1Layout::quadrants:
      return fill_quadrants(image, picture, camera);
    case Ffv1Layout::planes:
      return camera.format == PixelFormat::nv12 ? split_nv12(bytes, picture, camera)
                                                : split_pairs(bytes, picture, camera);
    case Ffv1Layout::none:
      break;
  }
}

std::vector<std::uint8_t> bytes_of(const AVFrame& picture, const TakeCamera& camera) {
  if (ffv1_layout(camera) == Ffv1Layout::quadrants) return bytes_of_quadrants(picture, camera);
  std::vector<std::uint8_t> bytes(image_bytes(camera.width, camera.height, camera.format));
  if (ffv1_layout(camera) == Ffv1Layout::rgb)
    cv::cvtColor(plane<cv::Vec4b>(picture, 0, camera.width, camera.height),
                 cv::Mat(camera.height, camera.width, CV_8UC3, bytes.data()), cv::COLOR_BGRA2RGB);
  else if (ffv1_layout(camera) == Ffv1Layout::grey)
    plane<std::uint8_t>(picture, 0, camera.width, camera.height).copyTo(samples_at<std::uint8_t>(bytes.data(), camera));
  else if (camera.format == PixelFormat::nv12)
    join_nv12(picture, bytes.data(), camera);
  else
    join_pairs(picture, bytes.data(), camera);
  return bytes;
}

AvCodec open_decoder(std::span<const std::uint8_t> configuration, const TakeCamera& camera) {
  AvCodec codec = make_decoder("ffv1");
  codec->width = camera.width;
  codec->height = camera.height;
  codec->thread_count = 1;
  codec->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
  codec->extradata = static_cast<std::uint8_t*>(av_mallocz(configuration.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  if (codec->extradata == nullptr) throw std::bad_alloc();
  codec->extradata_size = static_cast<int>(configuration.size());
  std::copy(configuration.begin(), configuration.end(), codec->extradata);
  return avcodec_open2(codec.get(), nullptr, nullptr) < 0 ? nullptr : std::move(codec);
}

}  // namespace

Ffv1Layout ffv1_layout(const TakeCamera& camera) {
  const PixelGroup group = pixel_group(camera.format);
  if (camera.width % group.across != 0 || camera.height % group.down != 0) return Ffv1Layout::none;
  const PixelLayout layout = layout_of(camera.format);
  if (layout.packing == PixelPacking::jpeg) return Ffv1Layout::none;
  if (layout.packing == PixelPacking::pfnc_12p && pixels_of(camera) % 2 != 0) return Ffv1Layout::none;
  if (is_ycbcr(camera.format)) return Ffv1Layout::planes;
  if (camera.format == PixelFormat::rgb8) return Ffv1Layout::rgb;
  return layout.order == BayerOrder::none ? Ffv1Layout::grey : Ffv1Layout::quadrants;
}

std::string_view to_string(Ffv1Layout layout) {
  switch (layout) {
    case Ffv1Layout::rgb:
      return "rgb";
    case Ffv1Layout::grey:
      return "grey";
    case Ffv1Layout::quadrants:
      return "bayer-quadrants";
    case Ffv1Layout::planes:
      return "ycbcr-planes";
    case Ffv1Layout::none:
      break;
  }
  return "none";
}

Ffv1Encoder::Ffv1Encoder(const TakeCamera& camera, const AVRational& rate)
    : camera_(camera), codec_(make_encoder("ffv1")) {
  codec_->width = camera.width;
  codec_->height = camera.height;
  codec_->pix_fmt = picture_format(camera);
  codec_->time_base = av_inv_q(rate);
  codec_->level = 3;
  codec_->gop_size = 1;
  codec_->slices = kSlices;
  codec_->thread_count = 1;
  av_opt_set_int(codec_->priv_data, "slicecrc", 1, 0);
  if (camera.format != PixelFormat::rgb8 && !deep(camera)) av_opt_set_int(codec_->priv_data, "coder", kGolombRice, 0);
  check(avcodec_open2(codec_.get(), nullptr, nullptr), camera.name + ": FFV1 encoder");
}

void Ffv1Encoder::describe(AVCodecParameters& parameters) const {
  check(avcodec_parameters_from_context(&parameters, codec_.get()), camera_.name + ": FFV1 encoder");
  if (is_ycbcr(camera_.format)) describe_colours(parameters, camera_.ycbcr);
}

AvPacket Ffv1Encoder::encode(const Image& image) {
  AvFrame picture = make_frame();
  picture->format = codec_->pix_fmt;
  picture->width = camera_.width;
  picture->height = camera_.height;
  check(av_frame_get_buffer(picture.get(), 0), camera_.name + ": picture buffer");
  fill(image, *picture, camera_);
  picture->pts = encoded_++;
  check(avcodec_send_frame(codec_.get(), picture.get()), camera_.name + ": FFV1 encoder");
  AvPacket packet = make_packet();
  check(avcodec_receive_packet(codec_.get(), packet.get()), camera_.name + ": FFV1 encoder");
  return packet;
}

std::optional<std::vector<std::uint8_t>> decode_ffv1(std::span<const std::uint8_t> configuration,
                                                     std::span<const std::uint8_t> bytes, const TakeCamera& camera) {
  const AvCodec codec = open_decoder(configuration, camera);
  if (!codec) return std::nullopt;
  const AvPacket packet = make_packet();
  check(av_new_packet(packet.get(), static_cast<int>(bytes.size())), "FFV1 packet");
  std::copy(bytes.begin(), bytes.end(), packet->data);
  const AvFrame picture = make_frame();
  if (avcodec_send_packet(codec.get(), packet.get()) < 0) return std::nullopt;
  if (avcodec_receive_frame(codec.get(), picture.get()) < 0) return std::nullopt;
  if (picture->format != picture_format(camera) || picture->width != camera.width || picture->height != camera.height)
    return std::nullopt;
  return bytes_of(*picture, camera);
}

}  // namespace rotunda::capture
