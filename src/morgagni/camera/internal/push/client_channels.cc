// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/camera/internal/push/client_channels.h"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/device_id.h"
#include "morgagni/camera/internal/byte_io.h"
#include "morgagni/core/version.h"

namespace mor::internal::push {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxTextBytes = 1U << 20U;
constexpr std::size_t kMaxChannels = 64;
constexpr std::size_t kMaxTopicBytes = 256;
constexpr std::size_t kMaxAnswers = 64;  ///< To one text.
constexpr std::uint8_t kMessageData = 0x01;
constexpr double kMaxId = 4294967295.0;

std::string dump(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<std::uint32_t> id_of(const Json& json) {
  if (!json.is_number_integer() || json.get<double>() < 0.0 || json.get<double>() > kMaxId) {
    return std::nullopt;
  }
  return json.get<std::uint32_t>();
}

/// A text member, cut where it is too long to be anything known. Empty: it is none.
std::string text_of(const Json& json, const char* name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_string()) return {};
  return found->get_ref<const std::string&>().substr(0, kMaxTopicBytes);
}

const Json* list_of(const Json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_array() ? &*found : nullptr;
}

std::vector<Status> error(std::string message) {
  return {{StatusLevel::kError, std::move(message)}};
}

}  // namespace

std::vector<std::string> ClientChannels::greeting() {
  return {dump({{"op", "serverInfo"},
                {"name", std::string("Morgagni ") + kVersion},
                {"capabilities", {"clientPublish"}},
                {"supportedEncodings", {"cdr", "json"}},
                {"metadata", Json::object()}}),
          dump({{"op", "advertise"}, {"channels", Json::array()}})};
}

std::string ClientChannels::status_json(const Status& status) {
  return dump(
      {{"op", "status"}, {"level", static_cast<int>(status.level)}, {"message", status.message}});
}

std::vector<Status> ClientChannels::on_text(std::string_view text) {
  if (text.size() > kMaxTextBytes) {
    return error(fmt::format("a text of {} bytes, {} are read", text.size(), kMaxTextBytes));
  }
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return error("a text message must be a JSON object with an 'op'");
  const auto op = text_of(json, "op");
  const bool is_advertise = op == "advertise";
  if (!is_advertise && op != "unadvertise") {
    return error(
        fmt::format("'{}' is not offered: a device advertises channels and sends on them", op));
  }
  const char* name = is_advertise ? "channels" : "channelIds";
  const auto* list = list_of(json, name);
  if (list == nullptr) return error(fmt::format("{} has no list '{}'", op, name));
  std::vector<Status> answers;
  if (is_advertise && json.contains("device")) {
    if (auto answer = set_device(text_of(json, "device"))) answers.push_back(*std::move(answer));
  }
  for (const auto& each : *list) {
    auto answer = is_advertise ? advertise(each) : unadvertise(each);
    if (answer) answers.push_back(*std::move(answer));
    if (answers.size() >= kMaxAnswers) break;
  }
  return answers;
}

std::optional<Status> ClientChannels::set_device(const std::string& name) {
  if (const auto checked = check_device_id(name); !checked) {
    return Status{StatusLevel::kError, checked.error().message};
  }
  device_ = name;
  return std::nullopt;
}

template <class Json>
std::optional<Status> ClientChannels::advertise(const Json& json) {
  const auto id = json.is_object() && json.contains("id") ? id_of(json["id"]) : std::nullopt;
  const auto topic = json.is_object() ? text_of(json, "topic") : std::string();
  if (!id || topic.empty()) {
    return Status{StatusLevel::kError, "a channel must have an 'id' and a 'topic'"};
  }
  if (channels_.size() >= kMaxChannels && !channels_.contains(*id)) {
    return Status{StatusLevel::kError, fmt::format("more than {} channels", kMaxChannels)};
  }
  const auto encoding = text_of(json, "encoding");
  if (encoding != "cdr" && encoding != "json") {
    return Status{
        StatusLevel::kError,
        fmt::format("{} is encoded as '{}', only cdr and json are read", topic, encoding)};
  }
  const auto schema = text_of(json, "schemaName");
  const auto kind = message_kind(schema);
  channels_[*id] = {topic, kind, encoding == "cdr" ? Encoding::kCdr : Encoding::kJson};
  if (kind) return std::nullopt;
  return Status{StatusLevel::kWarning,
                fmt::format("{} ({}) is not used, only sensor_msgs Image, CompressedImage and "
                            "CameraInfo, and tf2_msgs/TFMessage",
                            topic,
                            schema)};
}

template <class Json>
std::optional<Status> ClientChannels::unadvertise(const Json& json) {
  const auto id = id_of(json);
  if (id && channels_.erase(*id) != 0) return std::nullopt;
  return Status{StatusLevel::kWarning, "a channel that was not advertised is given up"};
}

Result<std::optional<Arrival>> ClientChannels::on_binary(std::span<const std::byte> bytes) const {
  ByteReader in(bytes);
  const auto opcode = in.take<std::uint8_t>();
  const auto id = in.take<std::uint32_t>();
  if (!in.ok() || opcode != kMessageData) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("a binary message of {} bytes with opcode {} is none that is "
                                  "offered",
                                  bytes.size(),
                                  opcode));
  }
  const auto found = channels_.find(id);
  if (found == channels_.end()) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("channel {} was not advertised", id));
  }
  const auto& channel = found->second;
  if (!channel.kind) return std::optional<Arrival>();
  auto message = parse_message(*channel.kind, channel.encoding, bytes.subspan(in.position()));
  if (!message) {
    return make_error(message.error().code,
                      fmt::format("{}: {}", channel.topic, message.error().message));
  }
  return Arrival{channel.topic, *std::move(message)};
}

}  // namespace mor::internal::push
