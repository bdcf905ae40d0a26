// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/routes/documents_routes.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <thread>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/documentation/viewer.h"
#include "morgagni/session/document_case.h"
#include "morgagni/session/routes/api_json.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using api::Json;
using api::refuse;

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31U;
constexpr std::size_t kMaxAuthorBytes = 200;

std::string content_type(const std::string& name) {
  const auto ends = [&](const char* ending) { return name.ends_with(ending); };
  if (ends(".html")) return "text/html; charset=utf-8";
  if (ends(".pdf")) return "application/pdf";
  if (ends(".json")) return "application/json";
  if (ends(".png")) return "image/png";
  if (ends(".glb")) return "model/gltf-binary";
  if (ends(".3mf")) return "model/3mf";
  return "application/octet-stream";
}

Result<DocumentOptions> parse_options(const std::string& text, const fs::path& web_root) {
  MOR_TRY(const Json json, api::parse_object(text));
  DocumentOptions options;
  options.viewer_template = web_root / kViewerFile;
  if (const auto found = json.find("formats"); found != json.end()) {
    if (!found->is_array()) return refuse("formats must be a list of names");
    options.formats.clear();
    for (const auto& name : *found) {
      const auto format =
          name.is_string() ? parse_document_format(name.get<std::string>()) : std::nullopt;
      if (!format) return refuse(fmt::format("there is no format {}", name.dump()));
      options.formats.push_back(*format);
    }
  }
  if (const auto found = json.find("print"); found != json.end()) {
    if (*found != "filled" && *found != "shell")
      return refuse(fmt::format("print must be filled or shell, got {}", found->dump()));
    options.print.form = *found == "shell" ? PrintForm::kShell : PrintForm::kFilled;
  }
  MOR_TRY(options.print.wall_mm, api::number(json, "wall_mm", options.print.wall_mm));
  if (const auto found = json.find("author"); found != json.end()) {
    if (!found->is_string() || found->get<std::string>().size() > kMaxAuthorBytes)
      return refuse(fmt::format("author must be a text of up to {} bytes", kMaxAuthorBytes));
    options.author = found->get<std::string>();
  }
  MOR_CHECK(options.check());
  return options;
}

/// Makes one set of documents at a time.
class DocumentsDesk {
 public:
  DocumentsDesk(std::shared_ptr<const Case> body, fs::path web_root)
      : body_(std::move(body)), web_root_(std::move(web_root)) {}

  Result<Json> begin(const std::string& text) {
    MOR_TRY(auto options, parse_options(text, web_root_));
    {
      const std::scoped_lock lock(mutex_);
      if (state_ == "running") return refuse("documents are being made: wait, or stop that first");
      state_ = "running";
      stage_ = "begin";
      fraction_ = 0.0;
      error_.clear();
    }
    worker_ = std::jthread([this, options = std::move(options)](std::stop_token stop) {
      finish(document_case(
          *body_,
          {},
          options,
          [this](std::string_view stage, double fraction) { show(stage, fraction); },
          std::move(stop)));
    });
    return status();
  }

  Json stop() {
    worker_.request_stop();
    return status();
  }

  Json status() const {
    const std::scoped_lock lock(mutex_);
    Json json = {{"state", state_},
                 {"stage", stage_},
                 {"fraction", fraction_},
                 {"error", error_.empty() ? Json(nullptr) : Json(error_)},
                 {"folder", nullptr},
                 {"files", Json::array()},
                 {"remarks", Json::array()}};
    if (!made_) return json;
    json["folder"] = made_->folder.filename().string();
    json["remarks"] = made_->remarks;
    for (const auto& file : made_->files) {
      json["files"].push_back(
          {{"name", file.name}, {"bytes", file.num_bytes}, {"sha256", file.sha256}});
    }
    return json;
  }

  HttpResponse file(const HttpRequest& request) const {
    const auto name = request.query.find("name");
    const auto path = name == request.query.end() ? std::nullopt : path_of(name->second);
    if (!path) return api::answer(refuse("there is no such document"));
    auto bytes = read_text_file(*path, kMaxFileBytes);
    if (!bytes) return api::answer(tl::unexpected<Error>(bytes.error()));
    return {200, content_type(name->second), *std::move(bytes)};
  }

 private:
  /// Only what was made here is given out.
  std::optional<fs::path> path_of(const std::string& name) const {
    const std::scoped_lock lock(mutex_);
    if (!made_) return std::nullopt;
    const auto is_it = [&](const HashedFile& file) { return file.name == name; };
    if (std::none_of(made_->files.begin(), made_->files.end(), is_it)) return std::nullopt;
    return made_->folder / name;
  }

  void show(std::string_view stage, double fraction) {
    const std::scoped_lock lock(mutex_);
    stage_ = stage;
    fraction_ = fraction;
  }

  void finish(Result<DocumentSummary> made) {
    const std::scoped_lock lock(mutex_);
    if (made) {
      state_ = "done";
      made_ = *std::move(made);
      return;
    }
    state_ = made.error().code == ErrorCode::kCancelled ? "stopped" : "failed";
    error_ = made.error().message;
  }

  std::shared_ptr<const Case> body_;
  fs::path web_root_;
  mutable std::mutex mutex_;
  std::string state_ = "idle";
  std::string stage_;
  double fraction_ = 0.0;
  std::string error_;
  std::optional<DocumentSummary> made_;
  std::jthread worker_;  // Last: it ends before what it uses.
};

}  // namespace

std::vector<HttpRoute> make_documents_routes(std::shared_ptr<const Case> body,
                                             const fs::path& web_root) {
  const auto desk = std::make_shared<DocumentsDesk>(std::move(body), web_root);
  return {
      api::post("/api/documents", [=](const auto& text) { return desk->begin(text); }),
      api::get("/api/documents", [=](const HttpRequest&) { return api::answer(desk->status()); }),
      api::post("/api/documents/stop", [=](const auto&) -> Result<Json> { return desk->stop(); }),
      api::get("/api/documents/file", [=](const HttpRequest& r) { return desk->file(r); })};
}

}  // namespace mor
