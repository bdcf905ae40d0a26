// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include <glib.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/internal/push/messages.h"
#include "morgagni/core/glib_handles.h"

namespace mor::internal::push {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxNameBytes = 256;
constexpr std::size_t kMaxTransforms = 64;
/// JSON of many small values takes twenty times its size when it is read.
constexpr std::size_t kMaxJsonBytes = 4U << 20U;

/// Takes members of a stranger's making. Whoever asks for one that is not there, or is of another
/// kind, gets nothing, and fault() says which from then on.
class JsonReader {
 public:
  JsonReader(const Json& json, std::string& fault) : json_(json), fault_(fault) {}

  [[nodiscard]] bool has(const char* name) const {
    return json_.is_object() && json_.contains(name);
  }

  [[nodiscard]] JsonReader object(const char* name) const {
    static const Json kNone = Json::object();
    if (has(name) && json_[name].is_object()) return {json_[name], fault_};
    complain(name, "no object");
    return {kNone, fault_};
  }
  [[nodiscard]] std::string text(const char* name) const {
    if (has(name) && json_[name].is_string()) {
      return json_[name].get_ref<const std::string&>().substr(0, kMaxNameBytes);
    }
    complain(name, "no text");
    return {};
  }
  [[nodiscard]] double number(const char* name) const {
    if (has(name) && json_[name].is_number()) return json_[name].get<double>();
    complain(name, "no number");
    return 0.0;
  }
  [[nodiscard]] std::uint32_t whole(const char* name) const {
    const double value = number(name);
    if (value >= 0.0 && value <= 4294967295.0 && value == std::floor(value)) {
      return static_cast<std::uint32_t>(value);
    }
    complain(name, "no whole number of 32 bits");
    return 0;
  }
  [[nodiscard]] std::vector<double> numbers(const char* name, std::size_t most) const {
    std::vector<double> values;
    const bool is_list = has(name) && json_[name].is_array() && json_[name].size() <= most;
    if (!is_list) complain(name, "no list of numbers");
    for (std::size_t i = 0; is_list && i < json_[name].size(); ++i) {
      const auto& value = json_[name][i];
      if (!value.is_number()) complain(name, "no list of numbers");
      values.push_back(value.is_number() ? value.get<double>() : 0.0);
    }
    return values;
  }
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> exactly(const char* name) const {
    const auto values = numbers(name, N);
    std::array<double, N> all{};
    if (values.size() == N) {
      std::ranges::copy(values, all.begin());
    } else {
      complain(name, fmt::format("no list of {} numbers", N));
    }
    return all;
  }
  [[nodiscard]] std::vector<std::byte> base64(const char* name) const {
    if (!has(name) || !json_[name].is_string()) {
      complain(name, "no base64 text");
      return {};
    }
    gsize size = 0;
    const std::unique_ptr<guchar, FreeWith<g_free>> bytes(
        g_base64_decode(json_[name].get_ref<const std::string&>().c_str(), &size));
    const auto all = std::as_bytes(std::span(bytes.get(), size));
    return {all.begin(), all.end()};
  }
  [[nodiscard]] const Json& json() const { return json_; }

 private:
  void complain(const char* name, const std::string& what) const {
    if (fault_.empty()) fault_ = fmt::format("its member '{}' is {}", name, what);
  }

  const Json& json_;
  std::string& fault_;
};

std::uint64_t stamp_ns(const JsonReader& header) {
  const auto stamp = header.object("stamp");
  const auto nanoseconds = stamp.whole(stamp.has("nsec") ? "nsec" : "nanosec");
  return std::uint64_t{stamp.whole("sec")} * 1'000'000'000 + nanoseconds;
}

Picture read_picture(const JsonReader& in, bool is_compressed) {
  const auto header = in.object("header");
  Picture picture{.is_compressed = is_compressed};
  picture.stamp_ns = stamp_ns(header);
  picture.frame = header.text("frame_id");
  picture.encoding = in.text(is_compressed ? "format" : "encoding");
  if (!is_compressed) {
    picture.width_px = in.whole("width");
    picture.height_px = in.whole("height");
    picture.row_bytes = in.whole("step");
    picture.is_big_endian = in.has("is_bigendian") && in.json()["is_bigendian"] != 0 &&
                            in.json()["is_bigendian"] != false;
  }
  picture.data = in.base64("data");
  return picture;
}

RawCameraInfo read_camera_info(const JsonReader& in) {
  // ROS 1 has the capital letters.
  const auto name = [&](const char* small, const char* capital) {
    return in.has(small) ? small : capital;
  };
  RawCameraInfo raw;
  raw.frame = in.object("header").text("frame_id");
  raw.width_px = in.whole("width");
  raw.height_px = in.whole("height");
  if (in.has("distortion_model")) raw.lens_model = in.text("distortion_model");
  if (in.has("d") || in.has("D")) raw.d = in.numbers(name("d", "D"), 14);
  raw.k = in.exactly<9>(name("k", "K"));
  if (in.has("p") || in.has("P")) raw.p = in.exactly<12>(name("p", "P"));
  raw.is_part = (in.has("binning_x") && in.number("binning_x") > 1.0) ||
                (in.has("binning_y") && in.number("binning_y") > 1.0);
  return raw;
}

Result<Message> read_transforms(const JsonReader& in, std::string& fault) {
  const auto list = in.json().find("transforms");
  if (list == in.json().end() || !list->is_array() || list->size() > kMaxTransforms) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("its member 'transforms' is no list of at most {}", kMaxTransforms));
  }
  std::vector<Transform> transforms;
  for (const auto& each : *list) {
    const JsonReader item(each, fault);
    const auto transform = item.object("transform");
    const auto position = transform.object("translation");
    const auto turn = transform.object("rotation");
    MOR_TRY(auto made,
            checked(item.object("header").text("frame_id"),
                    item.text("child_frame_id"),
                    {position.number("x"), position.number("y"), position.number("z")},
                    {turn.number("x"), turn.number("y"), turn.number("z"), turn.number("w")}));
    transforms.push_back(std::move(made));
  }
  return transforms;
}

Result<Message> read_message(MessageKind kind, const JsonReader& in, std::string& fault) {
  switch (kind) {
    case MessageKind::kImage:
    case MessageKind::kCompressedImage:
      return read_picture(in, kind == MessageKind::kCompressedImage);
    case MessageKind::kCameraInfo: {
      const auto raw = read_camera_info(in);
      if (!fault.empty()) break;
      return checked(raw);
    }
    case MessageKind::kTransforms:
      return read_transforms(in, fault);
  }
  return std::vector<Transform>();
}

}  // namespace

Result<Message> parse_json(MessageKind kind, std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxJsonBytes) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "a JSON message has {} bytes, {} are read: send cdr", bytes.size(), kMaxJsonBytes));
  }
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const Json json = Json::parse(text, text + bytes.size(), nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) {
    return make_error(ErrorCode::kInvalidArgument, "a message that should be JSON is none");
  }
  std::string fault;
  const JsonReader in(json, fault);
  auto message = read_message(kind, in, fault);
  if (!fault.empty()) {
    return make_error(ErrorCode::kInvalidArgument, "a JSON message is wrong: " + fault);
  }
  return message;
}

}  // namespace mor::internal::push
