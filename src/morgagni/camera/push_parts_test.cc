// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <random>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <zstd.h>

#include "morgagni/camera/internal/byte_io.h"
#include "morgagni/camera/internal/push/client_channels.h"
#include "morgagni/camera/internal/push/inbox.h"
#include "morgagni/camera/internal/push/picture_decoder.h"
#include "morgagni/camera/internal/push/rvl.h"
#include "morgagni/camera/internal/ros/messages.h"
#include "morgagni/camera/testing/sample_recording.h"
#include "morgagni/core/image_jpeg.h"
#include "morgagni/core/image_png.h"

namespace mor::internal::push {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::byte> joined(std::vector<std::byte> a, std::span<const std::byte> b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

template <class... T>
std::vector<std::byte> numbers(T... values) {
  ByteWriter out;
  (out.put(values), ...);
  return out.take();
}

// By hand from the paper: 3 zeros, 3 others: +500 +2 -3 folded to 1000 4 5; 1 zero, 2 others:
// 65535 - 499 folded to 130072, 1 - 65535 to 131067. In groups 3 3 8df1 4 5 | 1 2 8b83f3 ... of
// 4 bits, eight to a word, words little-endian.
const auto kRvl =
    bytes_of({0x45, 0xf1, 0x8d, 0x33, 0xf3, 0x8e, 0x8b, 0x12, 0x00, 0xf3, 0xff, 0xbf});
const std::vector<std::uint16_t> kRvlDepth = {0, 0, 0, 500, 502, 499, 0, 65535, 1};

TEST(Rvl, UnpacksWhatThePaperPacks) {
  std::vector<std::uint16_t> pixels(kRvlDepth.size());
  ASSERT_TRUE(decode_rvl(kRvl, pixels));
  EXPECT_EQ(pixels, kRvlDepth);
}

TEST(Rvl, SaysWhereItBreaksOff) {
  std::vector<std::uint16_t> pixels(kRvlDepth.size());
  for (std::size_t size = 0; size < kRvl.size(); ++size) {
    EXPECT_THAT(decode_rvl({kRvl.data(), size}, pixels).error().message, HasSubstr("of 9 pixels"));
  }
  std::vector<std::uint16_t> fewer(5);
  EXPECT_FALSE(decode_rvl(kRvl, fewer)) << "a run leaves the picture";
  const std::vector<std::byte> endless(64, std::byte{0xff});
  EXPECT_FALSE(decode_rvl(endless, pixels)) << "a number that never ends";
  const std::vector<std::byte> nothing(4096, std::byte{0});
  EXPECT_FALSE(decode_rvl(nothing, pixels)) << "runs of nothing";
}

TEST(Rvl, NoiseIsUnpackedOrRefusedWithinThePicture) {
  std::mt19937 random(7);
  std::vector<std::byte> noise(256);
  std::vector<std::uint16_t> pixels(300);
  for (int i = 0; i < 3000; ++i) {
    for (auto& byte : noise) byte = static_cast<std::byte>(random() & 0xFFU);
    (void)decode_rvl(noise, pixels);
  }
}

Picture compressed(std::string format, std::vector<std::byte> data) {
  return {.is_compressed = true, .encoding = std::move(format), .data = std::move(data)};
}

Picture plain(std::string encoding,
              std::uint32_t width,
              std::uint32_t row_bytes,
              std::vector<std::byte> data) {
  return {.encoding = std::move(encoding),
          .width_px = width,
          .height_px = static_cast<std::uint32_t>(data.size() / row_bytes),
          .row_bytes = row_bytes,
          .data = std::move(data)};
}

TEST(PushedDepth, ComesThroughEveryCodingToTheLastBit) {
  Image<std::uint16_t> depth(3, 3);
  std::ranges::copy(kRvlDepth, depth.data());
  const auto raw = std::as_bytes(std::span(depth.data(), depth.size()));
  const auto png = encode_png(depth.view());
  const auto head = numbers(std::int32_t{0}, 0.0F, 0.0F);
  std::vector<std::byte> zstd(256);
  zstd.resize(ZSTD_compress(zstd.data(), zstd.size(), raw.data(), raw.size(), 1));
  const auto zstd_head =
      joined(numbers(3U, 3U, std::uint8_t{0}, 6U, 5U), std::as_bytes(std::span("16UC1", 5)));
  const std::vector<Picture> pictures = {
      plain("16UC1", 3, 6, {raw.begin(), raw.end()}),
      compressed("png", png),
      compressed("16UC1; png compressed ", png),
      compressed("16UC1; compressedDepth", joined(head, png)),
      compressed("16UC1; compressedDepth png", joined(head, png)),
      compressed("16UC1; compressedDepth rvl", joined(joined(head, numbers(3U, 3U)), kRvl)),
      compressed("zstd", joined(zstd_head, zstd))};
  for (const auto& picture : pictures) {
    EXPECT_TRUE(is_depth(picture)) << picture.encoding;
    const auto decoded = decode_depth_picture(picture, {3, 3});
    ASSERT_TRUE(decoded) << picture.encoding << ": " << decoded.error().message;
    EXPECT_EQ(*decoded, depth) << picture.encoding;
    EXPECT_THAT(decode_depth_picture(picture, {4, 3}).error().message, HasSubstr("3x3"));
    auto cut = picture;
    cut.data.resize(cut.data.size() - 5);
    EXPECT_FALSE(decode_depth_picture(cut, {3, 3})) << picture.encoding;
  }
}

TEST(PushedDepth, MetresBecomeMillimetresAndNoReadingBecomesZero) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const auto depth = decode_depth_picture(
      plain("32FC1", 4, 16, numbers(0.5004F, nan, infinite, -1.0F, 65.535F, 66.0F, 0.0F, 1.2346F)),
      {4, 2});
  ASSERT_TRUE(depth) << depth.error().message;
  EXPECT_THAT(std::vector(depth->data(), depth->data() + 8),
              ElementsAre(500, 0, 0, 0, 65535, 0, 0, 1235));
}

TEST(PushedDepth, InverseDepthOfCompressedDepthIsTurnedBack) {
  // As compressed_depth_image_transport quantises: a = 100 * 101, b = 1 - a / 10.
  const float a = 10100.0F, b = 1.0F - a / 10.0F;
  Image<std::uint16_t> inverse(2, 1);
  inverse(0, 0) = static_cast<std::uint16_t>(a / 0.8F + b);
  const auto picture =
      compressed("32FC1; compressedDepth png",
                 joined(numbers(std::int32_t{0}, a, b), encode_png(inverse.view())));
  const auto depth = decode_depth_picture(picture, {2, 1}).value();
  EXPECT_NEAR(depth(0, 0), 800, 1);
  EXPECT_EQ(depth(1, 0), 0);
}

TEST(PushedDepth, RowsMayBeLongerThanTheirPixelsButNotShorter) {
  auto data =
      numbers(std::uint16_t{1}, std::uint16_t{2}, 0U, std::uint16_t{3}, std::uint16_t{4}, 0U);
  const auto depth = decode_depth_picture(plain("16UC1", 2, 8, data), {2, 2}).value();
  EXPECT_EQ(depth(1, 1), 4);
  auto picture = plain("16UC1", 2, 8, data);
  picture.row_bytes = 3;
  EXPECT_THAT(decode_depth_picture(picture, {2, 2}).error().message, HasSubstr("3 bytes a row"));
  picture.row_bytes = 0xFFFFFFFF;
  EXPECT_FALSE(decode_depth_picture(picture, {2, 2}));
  picture = plain("16UC1", 2, 8, data);
  picture.is_big_endian = true;
  EXPECT_THAT(decode_depth_picture(picture, {2, 2}).error().message, HasSubstr("big-endian"));
}

TEST(PushedDepth, ABombIsRefusedBeforeItIsUnpacked) {
  // A PNG and an RVL that say 30000x30000; a zstd of 1 GiB of zeros.
  auto png = encode_png(Image<std::uint16_t>(3, 3).view());
  png[18] = png[22] = std::byte{0x75};
  EXPECT_THAT(decode_depth_picture(compressed("png", png), {3, 3}).error().message,
              HasSubstr("the camera's have 3x3"));
  const auto rvl = joined(numbers(0, 0, 0, 30000U, 30000U), kRvl);
  EXPECT_THAT(
      decode_depth_picture(compressed("16UC1; compressedDepth rvl", rvl), {3, 3}).error().message,
      HasSubstr("30000x30000"));
  const auto head = joined(numbers(3U, 3U, std::uint8_t{0}, 0xFFFFFFFFU, 5U),
                           std::as_bytes(std::span("16UC1", 5)));
  EXPECT_THAT(decode_depth_picture(compressed("zstd", head), {3, 3}).error().message,
              HasSubstr("rows are too long"));
}

TEST(PushedColor, ComesThroughEveryCoding) {
  Image<Rgb8> color(4, 2);
  for (int i = 0; i < 8; ++i) {
    color.data()[i] = {static_cast<std::uint8_t>(10 * i), static_cast<std::uint8_t>(200 - i), 7};
  }
  std::vector<std::byte> rgb, bgra;
  for (int i = 0; i < 8; ++i) {
    const auto& [r, g, b] = color.data()[i];
    for (const int value : {int{r}, int{g}, int{b}}) rgb.push_back(static_cast<std::byte>(value));
    for (const int value : {int{b}, int{g}, int{r}, 255})
      bgra.push_back(static_cast<std::byte>(value));
  }
  for (const auto& picture : {plain("rgb8", 4, 12, rgb),
                              plain("bgra8", 4, 16, bgra),
                              compressed("png", encode_png(color.view())),
                              compressed("rgb8; png compressed bgr8", encode_png(color.view()))}) {
    EXPECT_FALSE(is_depth(picture)) << picture.encoding;
    const auto decoded = decode_color_picture(picture, {4, 2});
    ASSERT_TRUE(decoded) << picture.encoding << ": " << decoded.error().message;
    EXPECT_EQ(*decoded, color) << picture.encoding;
  }
  const auto jpeg =
      compressed("jpeg", encode_jpeg(Image<Rgb8>(8, 8, {9, 9, 9}).view(), 90).value());
  EXPECT_EQ(decode_color_picture(jpeg, {8, 8}).value().width(), 8);
  EXPECT_THAT(decode_color_picture(jpeg, {8, 9}).error().message, HasSubstr("8x8"));
  EXPECT_THAT(decode_color_picture(compressed("jpeg", numbers(1, 2, 3)), {8, 8}).error().message,
              HasSubstr("JPEG"));
  EXPECT_THAT(decode_color_picture(plain("yuv422", 4, 8, numbers(0, 0)), {4, 1}).error().message,
              HasSubstr("'yuv422'"));
}

std::vector<std::byte> info_bytes(const PinholeCamera& camera) {
  return ros::encode_camera_info({1, "depth"}, camera);
}

TEST(PushedMessages, CameraInfoIsTakenOrRefusedWithASentence) {
  const auto& camera = sample_calibration()->depth;
  const auto read = [](const std::vector<std::byte>& bytes) {
    return parse_message(MessageKind::kCameraInfo, Encoding::kCdr, bytes);
  };
  const auto message = read(info_bytes(camera));
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_EQ(std::get<CameraInfo>(*message).as_seen, camera);
  auto flat = camera;
  flat.distortion = {};
  EXPECT_EQ(std::get<CameraInfo>(*message).rectified, flat);
  auto bad = camera;
  bad.focal_x_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(read(info_bytes(bad)).error().message, HasSubstr("not finite"));
  bad.focal_x_px = -5.0;
  EXPECT_THAT(read(info_bytes(bad)).error().message, HasSubstr("focal"));
  bad = camera;
  bad.width_px = bad.height_px = 16000;
  EXPECT_THAT(read(info_bytes(bad)).error().message, HasSubstr("at most"));
  const auto whole = info_bytes(camera);
  for (std::size_t size = 0; size + 9 < whole.size(); ++size) {
    EXPECT_FALSE(read({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)})) << size;
  }
}

TEST(PushedMessages, ALensModelThatIsNotOursIsRefusedUnlessItsMoreAreZero) {
  RawCameraInfo raw;
  raw.width_px = 640;
  raw.height_px = 480;
  raw.lens_model = "rational_polynomial";
  raw.k = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  raw.d = {0.1, 0.2, 0, 0, 0.3, 0, 0, 0};
  EXPECT_EQ(checked(raw).value().as_seen.distortion[4], 0.3);
  EXPECT_FALSE(checked(raw).value().rectified);
  raw.d[6] = 0.1;
  EXPECT_THAT(checked(raw).error().message, HasSubstr("rectified pictures"));
  raw.lens_model = "equidistant";
  raw.d = {0.1, 0, 0, 0};
  EXPECT_THAT(checked(raw).error().message, HasSubstr("equidistant"));
  raw.is_part = true;
  EXPECT_THAT(checked(raw).error().message, HasSubstr("cut"));
}

TEST(PushedMessages, JsonSaysTheSameAsCdr) {
  const auto parse = [](MessageKind kind, const std::string& text) {
    return parse_message(kind, Encoding::kJson, std::as_bytes(std::span(text)));
  };
  const auto picture = std::get<Picture>(
      parse(
          MessageKind::kCompressedImage,
          R"({"header":{"stamp":{"sec":3,"nanosec":7},"frame_id":"c"},"format":"jpeg","data":"AQID"})")
          .value());
  EXPECT_EQ(picture.stamp_ns, 3'000'000'007U);
  EXPECT_EQ(picture.data, bytes_of({1, 2, 3}));
  const auto info = std::get<CameraInfo>(
      parse(MessageKind::kCameraInfo,
            R"({"header":{"stamp":{"sec":3,"nsec":7},"frame_id":"c"},"width":4,"height":3,
                "K":[5,0,2,0,6,1,0,0,1]})")
          .value());
  EXPECT_EQ(info.as_seen.focal_y_px, 6.0);
  const auto error = [&](MessageKind kind, const std::string& text) {
    const auto message = parse(kind, text);
    return message ? "taken" : message.error().message;
  };
  EXPECT_THAT(error(MessageKind::kImage, "[1]"), HasSubstr("JSON"));
  EXPECT_THAT(error(MessageKind::kImage, "{}"), HasSubstr("'header'"));
  EXPECT_THAT(error(MessageKind::kCameraInfo,
                    R"({"header":{"frame_id":"c"},"width":-4,"height":3,"K":[5]})"),
              HasSubstr("'width'"));
  EXPECT_THAT(error(MessageKind::kTransforms, R"({"transforms":[{}]})"), HasSubstr("'transform'"));
  EXPECT_THAT(error(MessageKind::kTransforms, std::string(200000, '[')), HasSubstr("JSON"));
}

TEST(ClientChannels, AnswersWhatItCannotUse) {
  ClientChannels channels;
  const auto answer = [&](const std::string& text) {
    const auto answers = channels.on_text(text);
    return answers.empty() ? "" : answers.front().message;
  };
  EXPECT_THAT(answer("nonsense"), HasSubstr("JSON object"));
  EXPECT_THAT(answer(std::string(500000, '[')), HasSubstr("JSON object"));
  EXPECT_THAT(answer(std::string(2U << 20U, ' ')), HasSubstr("bytes"));
  EXPECT_THAT(answer(R"({"op":"subscribe"})"), HasSubstr("'subscribe' is not offered"));
  EXPECT_THAT(answer(R"({"op":7})"), HasSubstr("not offered"));
  EXPECT_THAT(answer(R"({"op":"advertise"})"), HasSubstr("channels"));
  EXPECT_THAT(answer(R"({"op":"advertise","channels":[{"id":-1,"topic":"a"}]})"),
              HasSubstr("'id'"));
  EXPECT_THAT(answer(R"({"op":"advertise","channels":[{"id":1,"topic":"/a","encoding":"ros1"}]})"),
              HasSubstr("'ros1'"));
  EXPECT_THAT(answer(R"({"op":"advertise","channels":[{"id":1,"topic":"/imu","encoding":"cdr",
                         "schemaName":"sensor_msgs/msg/Imu"}]})"),
              HasSubstr("/imu"));
  EXPECT_THAT(answer(R"({"op":"unadvertise","channelIds":[5]})"), HasSubstr("not advertised"));
  const auto used = numbers(std::uint8_t{1}, 1U);
  EXPECT_FALSE(channels.on_binary(used).value()) << "of a channel that is not used";
  EXPECT_THAT(channels.on_binary(numbers(std::uint8_t{1}, 9U)).error().message,
              HasSubstr("channel 9"));
  EXPECT_THAT(channels.on_binary(numbers(std::uint8_t{2}, 1U)).error().message,
              HasSubstr("opcode 2"));
  EXPECT_FALSE(channels.on_binary({}));
  std::string last;
  for (int i = 0; i < 70; ++i) {
    last = answer(R"({"op":"advertise","channels":[{"id":)" + std::to_string(i) +
                  R"(,"topic":"/a","encoding":"cdr","schemaName":"sensor_msgs/Image"}]})");
  }
  EXPECT_THAT(last, HasSubstr("more than 64 channels"));
}

TEST(ClientChannels, HearsWhoTheDeviceIs) {
  ClientChannels channels;
  EXPECT_EQ(channels.device(), "");
  EXPECT_THAT(channels.on_text(R"({"op":"advertise","channels":[],"device":"D435.9044"})"),
              IsEmpty());
  EXPECT_EQ(channels.device(), "D435.9044");
  for (const char* name : {R"("../kinect")", R"("")", R"(7)", R"("a b")", R"(".x")"}) {
    const auto answers =
        channels.on_text(fmt::format(R"({{"op":"advertise","channels":[],"device":{}}})", name));
    ASSERT_EQ(answers.size(), 1U) << name;
    EXPECT_THAT(answers[0].message, HasSubstr("is no device's id"));
    EXPECT_EQ(channels.device(), "D435.9044") << "as it was";
  }
}

TEST(ClientChannels, GreetsAsTheProtocolWants) {
  const auto info = nlohmann::json::parse(ClientChannels::greeting().front());
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["capabilities"], nlohmann::json({"clientPublish"}));
  EXPECT_EQ(info["supportedEncodings"], nlohmann::json({"cdr", "json"}));
}

constexpr std::uint64_t kMs = 1'000'000;

class InboxTest : public testing::Test {
 protected:
  virtual Result<void> put(const std::string& topic, Message message) {
    return inbox_.put({topic, std::move(message)}, now_);
  }
  Result<void> depth(std::uint64_t stamp_ms) {
    Picture picture = plain("16UC1", 1, 2, numbers(std::uint16_t{500}));
    picture.stamp_ns = stamp_ms * kMs;
    picture.frame = "depth";
    return put("/camera/depth/image_raw", picture);
  }
  Result<void> color(std::uint64_t stamp_ms) {
    Picture picture = compressed("jpeg", numbers(1));
    picture.stamp_ns = stamp_ms * kMs;
    picture.frame = "color";
    return put("/camera/color/image_raw/compressed", picture);
  }
  void describe() {
    CameraInfo info{.frame = "depth", .as_seen = sample_calibration()->depth};
    ASSERT_TRUE(put("/camera/depth/camera_info", info));
    info.as_seen = sample_calibration()->color;
    ASSERT_TRUE(put("/camera/color/camera_info", info));
    Transform turn{.parent = "base", .child = "depth"};
    turn.parent_from_child.translation() << 10.0, 0.0, 0.0;
    Transform other{.parent = "base", .child = "color"};
    other.parent_from_child.translation() << 35.0, 0.0, 0.0;
    ASSERT_TRUE(put("/tf_static", std::vector<Transform>{turn, other}));
  }
  std::optional<Pair> take() { return inbox_.wait(milliseconds(0), {}); }

  Inbox inbox_{"ws://here", {}};
  Clock::time_point now_ = Clock::now();
};

/// Of the device A1 a calibration is kept.
class KnownDeviceTest : public InboxTest {
 protected:
  KnownDeviceTest() { make(""); }
  void make(const std::string& device_id) {
    device_ = std::make_unique<Inbox>(
        "ws://here",
        InboxOptions{.device_id = device_id, .known = [this](const auto& id, const auto& said) {
                       return known(id, said);
                     }});
  }
  Result<std::optional<RgbdCalibration>> known(const std::string& id, const RgbdCalibration& said) {
    ++num_asked_;
    if (id != "push-A1") return std::nullopt;
    auto kept = said;
    kept.depth.focal_x_px = 77.0;
    kept.origin = "board, 2026-01-31T10:00:00Z";
    return kept;
  }
  Result<void> put(const std::string& topic, Message message) override {
    return device_->put({topic, std::move(message)}, now_);
  }
  /// Of a device that has just come.
  Pair pair_of(const std::string& name, std::uint64_t stamp_ms) {
    device_->device_went();
    device_->device_came();
    if (!name.empty()) device_->device_is(name);
    describe();
    EXPECT_TRUE(depth(stamp_ms));
    EXPECT_TRUE(color(stamp_ms));
    return device_->wait(milliseconds(0), {}).value();
  }

  int num_asked_ = 0;
  std::unique_ptr<Inbox> device_;
};

TEST_F(InboxTest, PairsByStampAndTheNewestWins) {
  inbox_.device_came();
  describe();
  EXPECT_TRUE(depth(100));
  EXPECT_FALSE(take());
  EXPECT_TRUE(color(130)) << "too far apart";
  EXPECT_FALSE(take());
  EXPECT_TRUE(depth(133));
  now_ += milliseconds(33);
  EXPECT_TRUE(depth(166));
  EXPECT_TRUE(color(163));
  const auto pair = take();
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->depth.stamp_ns, 166 * kMs) << "the newest";
  EXPECT_EQ(pair->color.stamp_ns, 163 * kMs);
  EXPECT_EQ(pair->arrived_at, now_);
  EXPECT_EQ(pair->calibration->depth, sample_calibration()->depth);
  EXPECT_EQ(pair->calibration->color, sample_calibration()->color);
  EXPECT_DOUBLE_EQ(pair->calibration->color_from_depth.translation().x(), -25.0);
  EXPECT_FALSE(take());
}

TEST_F(InboxTest, SaysWhatIsMissing) {
  EXPECT_THAT(inbox_.reason(), AllOf(HasSubstr("no device"), HasSubstr("ws://here")));
  inbox_.device_came();
  EXPECT_THAT(inbox_.reason(), HasSubstr("sends no pictures"));
  EXPECT_TRUE(depth(100));
  EXPECT_THAT(inbox_.reason(), HasSubstr("no colour"));
  EXPECT_THAT(color(100).error().message,
              AllOf(HasSubstr("/camera/depth/image_raw"), HasSubstr("CameraInfo")));
  ASSERT_TRUE(put("/camera/camera_info", CameraInfo{"x", sample_calibration()->depth}));
  now_ += milliseconds(33);
  EXPECT_THAT(depth(110).error().message,
              AllOf(HasSubstr("'color' and 'depth'"), HasSubstr("TFMessage")));
  EXPECT_TRUE(depth(510));
  EXPECT_THAT(inbox_.reason(), HasSubstr("more than 20 ms apart"));
  inbox_.refuse("that");
  EXPECT_THAT(inbox_.reason(), HasSubstr("cannot be used: that"));
  inbox_.device_went();
  EXPECT_THAT(inbox_.reason(), HasSubstr("no device"));
}

TEST_F(KnownDeviceTest, TakesTheKeptCalibrationInPlaceOfItsOwnWord) {
  const auto pair = pair_of("A1", 100);
  EXPECT_EQ(pair.device_id, "push-A1");
  EXPECT_EQ(pair.calibration->origin, "board, 2026-01-31T10:00:00Z");
  EXPECT_EQ(pair.calibration->depth.focal_x_px, 77.0);
  EXPECT_EQ(pair_of("A1", 200).calibration, pair.calibration) << "after a reconnection";
  EXPECT_EQ(num_asked_, 1);
  const auto other = pair_of("B2", 300);
  EXPECT_EQ(other.device_id, "push-B2");
  EXPECT_EQ(other.calibration->depth, sample_calibration()->depth);
  EXPECT_EQ(pair_of("", 400).device_id, "") << "what the last device said is forgotten";
  EXPECT_EQ(num_asked_, 2) << "nothing is known of who has no name";
}

TEST_F(KnownDeviceTest, IsWhoTheUserSays) {
  make("mine");
  EXPECT_EQ(pair_of("A1", 100).device_id, "mine");
  EXPECT_EQ(pair_of("", 200).device_id, "mine");
}

TEST_F(InboxTest, WrongStampsAreRefused) {
  inbox_.device_came();
  EXPECT_TRUE(depth(1000));
  now_ += milliseconds(33);
  EXPECT_THAT(depth(1000).error().message, HasSubstr("stand still"));
  EXPECT_THAT(depth(900).error().message, HasSubstr("backward"));
  now_ += milliseconds(33);
  EXPECT_THAT(depth(3'600'900).error().message, HasSubstr("jumps by 3600.0 s"));
  now_ += milliseconds(33);
  EXPECT_TRUE(depth(3'600'933)) << "a clock that was set goes on";
}

TEST_F(InboxTest, KeepsAFewPicturesHoweverManyCome) {
  inbox_.device_came();
  describe();
  for (std::uint64_t i = 0; i < 1000; ++i) {
    now_ += milliseconds(100);
    ASSERT_TRUE(color(5'000'000 + i));
    ASSERT_TRUE(depth(100 * (i + 1)));
  }
  EXPECT_FALSE(take());
  // Only the last four of each are there to be paired with.
  now_ += milliseconds(1);
  EXPECT_TRUE(color(100 * 996));
  EXPECT_FALSE(take());
  EXPECT_TRUE(color(100 * 997));
  EXPECT_TRUE(take());
}

TEST_F(InboxTest, RectifiedPicturesTakeTheProjectionMatrix) {
  inbox_.device_came();
  describe();
  CameraInfo info{"depth", sample_calibration()->depth, sample_calibration()->depth};
  info.rectified->distortion = {};
  ASSERT_TRUE(put("/camera/depth/camera_info", info));
  Picture picture = plain("16UC1", 1, 2, numbers(std::uint16_t{500}));
  picture.stamp_ns = 100 * kMs;
  picture.frame = "depth";
  ASSERT_TRUE(put("/camera/depth/image_rect_raw", picture));
  ASSERT_TRUE(color(100));
  EXPECT_FALSE(take().value().calibration->depth.has_distortion());
}

}  // namespace
}  // namespace mor::internal::push
