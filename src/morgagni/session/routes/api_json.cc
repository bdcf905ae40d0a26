// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/api_json.h"

#include <charconv>
#include <cstddef>
#include <iterator>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/image_png.h"
#include "morgagni/core/printable_text.h"

namespace mor::api {
namespace {

int http_status(ErrorCode code) {
  return code == ErrorCode::kInvalidArgument ? 400 : 500;
}

HttpResponse png(const std::vector<std::byte>& bytes) {
  return {200, "image/png", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size())};
}

}  // namespace

tl::unexpected<Error> refuse(const std::string& sentence) {
  return make_error(ErrorCode::kInvalidArgument, sentence);
}

HttpResponse answer(const Result<Json>& result) {
  if (result) return {200, "application/json", result->dump()};
  return {http_status(result.error().code),
          "application/json",
          Json{{"error", printable_text(result.error().message)}}.dump()};
}

HttpResponse png_answer(ImageView<const Rgb8> picture) {
  return png(encode_png(picture));
}

HttpResponse png_answer(ImageView<const Rgba8> picture) {
  return png(encode_png(picture));
}

Result<Json> done(const Result<void>& result) {
  if (!result) return tl::unexpected<Error>(result.error());
  return Json::object();
}

HttpRoute post(std::string path, std::function<Result<Json>(const std::string&)> act) {
  return {"POST", std::move(path), [act = std::move(act)](const HttpRequest& request) {
            return answer(act(request.body));
          }};
}

HttpRoute get(std::string path, std::function<HttpResponse(const HttpRequest&)> act) {
  return {"GET", std::move(path), std::move(act)};
}

Result<Json> parse_object(const std::string& text) {
  Json json = Json::parse(text.empty() ? "{}" : text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return refuse("the request must be a JSON object");
  return json;
}

Result<double> number(const Json& json, const std::string& name, std::optional<double> fallback) {
  const auto found = json.find(name);
  if (found == json.end() && fallback) return *fallback;
  if (found == json.end() || !found->is_number())
    return refuse(fmt::format("{} must be a number", name));
  return found->get<double>();
}

Result<bool> truth(const Json& json, const std::string& name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_boolean()) {
    return refuse(fmt::format("{} must be true or false", name));
  }
  return found->get<bool>();
}

Result<Eigen::Vector3d> point(const Json& json, const std::string& name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array() || found->size() != 3) {
    return refuse(fmt::format("{} must be three numbers", name));
  }
  Eigen::Vector3d result;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(*found)[i].is_number()) return refuse(fmt::format("{} must be three numbers", name));
    result[static_cast<Eigen::Index>(i)] = (*found)[i].get<double>();
  }
  return result;
}

Result<Json> numbers(const std::map<std::string, std::string>& query) {
  Json json = Json::object();
  for (const auto& [name, text] : query) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
      return refuse(fmt::format("{} must be a number, got \"{}\"", name, text));
    }
    json[name] = value;
  }
  return json;
}

Json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

std::vector<HttpRoute> joined(std::vector<std::vector<HttpRoute>> topics) {
  std::vector<HttpRoute> all;
  for (auto& routes : topics) {
    all.insert(
        all.end(), std::make_move_iterator(routes.begin()), std::make_move_iterator(routes.end()));
  }
  return all;
}

}  // namespace mor::api
