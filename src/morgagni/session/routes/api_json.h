// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// What the files of routes (`*_routes.cc`) share: JSON in, JSON or a sentence out.
namespace api {

using Json = nlohmann::json;

/// The error of a request that cannot be granted.
[[nodiscard]] tl::unexpected<Error> refuse(const std::string& sentence);

/// 200 with the JSON, or 4xx and 5xx with the sentence.
[[nodiscard]] HttpResponse answer(const Result<Json>& result);
[[nodiscard]] HttpResponse png_answer(ImageView<const Rgb8> picture);
[[nodiscard]] HttpResponse png_answer(ImageView<const Rgba8> picture);

/// An empty object where nothing is to be said but that it is done.
[[nodiscard]] Result<Json> done(const Result<void>& result);

/// The route of a command: `act` gets the request's body.
[[nodiscard]] HttpRoute post(std::string path, std::function<Result<Json>(const std::string&)> act);
[[nodiscard]] HttpRoute get(std::string path, std::function<HttpResponse(const HttpRequest&)> act);

/// @errors kInvalidArgument: what is wrong with the request, in words for who made it.
[[nodiscard]] Result<Json> parse_object(const std::string& text);
[[nodiscard]] Result<double> number(const Json& json,
                                    const std::string& name,
                                    std::optional<double> fallback = {});
[[nodiscard]] Result<bool> truth(const Json& json, const std::string& name);
[[nodiscard]] Result<Eigen::Vector3d> point(const Json& json, const std::string& name);
/// The query's numbers as the JSON that a POST would have of them.
[[nodiscard]] Result<Json> numbers(const std::map<std::string, std::string>& query);

[[nodiscard]] Json to_json(const Eigen::Vector3d& v);
[[nodiscard]] Json or_null(const std::optional<double>& value);

/// The routes of several topics as one list.
[[nodiscard]] std::vector<HttpRoute> joined(std::vector<std::vector<HttpRoute>> topics);

}  // namespace api
}  // namespace mor
