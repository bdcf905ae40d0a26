// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/recorder.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/log.h"
#include "morgagni/session/evidence_json.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using std::chrono::system_clock;

constexpr std::chrono::milliseconds kLookPeriod{300};

VideoFiles part_files(const fs::path& folder, const std::string& name) {
  return {folder / (name + ".part.webm"), folder / (name + ".part.jsonl")};
}

/// The first so many lines; no half line, no line of a picture that did not reach the video.
Result<void> write_lines(const fs::path& from, const fs::path& to, std::uint64_t num_lines) {
  std::ifstream in(from, std::ios::binary);
  std::string kept;
  std::uint64_t count = 0;
  for (std::string line; count < num_lines && std::getline(in, line) && !in.eof(); ++count)
    kept.append(line).append("\n");
  return write_file(to, kept);
}

}  // namespace

Recorder::Recorder(std::shared_ptr<const Case> body,
                   InUse calibration,
                   Skin skin,
                   std::string camera_name)
    : body_(std::move(body)),
      calibration_(std::move(calibration)),
      skin_(std::move(skin)),
      camera_name_(std::move(camera_name)),
      folder_(body_->folder / "videos") {}

Recorder::~Recorder() {
  close();
}

void Recorder::run(LiveServer& server) {
  const std::lock_guard lock(mutex_);
  server_ = &server;
  thread_ = std::jthread([this](std::stop_token stop) { work(stop); });
}

void Recorder::close() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  server_ = nullptr;
}

Result<void> Recorder::take_folder() {
  if (lock_) return {};
  MOR_TRY(auto lock,
          FolderLock::make_and_take(
              folder_,
              FolderLock::Kind::kExclusive,
              "another Morgagni records videos of this case: stop that one first"));
  lock_ = std::move(lock);
  return {};
}

Result<void> Recorder::start() {
  const std::lock_guard lock(mutex_);
  if (server_ == nullptr)
    return make_error(ErrorCode::kInvalidArgument, "nothing is streamed that could be recorded");
  if (status_.state != RecorderState::kIdle) {
    return make_error(ErrorCode::kInvalidArgument,
                      status_.state == RecorderState::kRecording
                          ? "a video is being recorded already"
                          : "the last video is being finished: try again in a moment");
  }
  MOR_CHECK(take_folder());
  const auto now = system_clock::now();
  std::string name = evidence::file_name(now);
  for (int i = 2; fs::exists(folder_ / (name + ".webm")); ++i)
    name = fmt::format("{}-{}", evidence::file_name(now), i);
  MOR_CHECK(server_->start_video(part_files(folder_, name)));
  status_ = RecorderStatus{};
  status_.state = RecorderState::kRecording;
  status_.name = name;
  stop_wanted_ = false;
  changed_.notify_all();
  return {};
}

Result<void> Recorder::stop() {
  const std::lock_guard lock(mutex_);
  if (status_.state != RecorderState::kRecording)
    return make_error(ErrorCode::kInvalidArgument, "no video is being recorded");
  stop_wanted_ = true;
  changed_.notify_all();
  return {};
}

RecorderStatus Recorder::status() const {
  const std::lock_guard lock(mutex_);
  RecorderStatus status = status_;
  if (status.state == RecorderState::kRecording && server_ != nullptr)
    status.video = server_->video();
  return status;
}

void Recorder::work(std::stop_token stop) {
  finish_left_over();
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, stop, [this] { return status_.state == RecorderState::kRecording; });
    if (status_.state != RecorderState::kRecording) return;  // Stopped, and nothing to finish.
    while (!stop_wanted_ && !stop.stop_requested() && server_->video().problem.empty())
      changed_.wait_for(lock, stop, kLookPeriod, [this] { return stop_wanted_; });
    status_.state = RecorderState::kFinishing;
    const std::string name = status_.name;
    lock.unlock();
    const VideoStatus video = server_->stop_video();
    {
      const std::lock_guard status_lock(mutex_);
      status_.video = video;
    }
    finish(name, video.problem, false);
    lock.lock();
    status_.state = RecorderState::kIdle;
  }
}

void Recorder::finish_left_over() {
  std::error_code status;
  if (!fs::is_directory(folder_, status)) return;
  {
    const std::lock_guard lock(mutex_);
    if (!take_folder()) return;  // Somebody records there, or it cannot be written.
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_, status)) {
    const std::string file = entry.path().filename().string();
    constexpr std::string_view kPart = ".part.webm";
    if (file.ends_with(kPart)) names.push_back(file.substr(0, file.size() - kPart.size()));
  }
  std::sort(names.begin(), names.end());
  for (const auto& name : names) {
    {
      const std::lock_guard lock(mutex_);
      if (name == status_.name) continue;  // A new one has begun meanwhile.
    }
    finish(name, "", true);
  }
}

Result<double> Recorder::write_evidence(const std::string& name, const Ended& ended) const {
  MOR_TRY(const auto video_hash, sha256_hex_of_file(ended.video));
  MOR_TRY(const auto lines_hash, sha256_hex_of_file(ended.pictures));
  double seconds = 0.0;
  std::string first_at;
  std::ifstream in(ended.pictures);
  for (std::string line; std::getline(in, line);) {
    const auto json = evidence::Json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!json.is_object() || !json.contains("time_s")) continue;
    seconds = json["time_s"].get<double>();
    if (first_at.empty()) first_at = json.value("captured_at", "");
  }
  evidence::Json json = evidence::head(*body_);
  json["kind"] = "AR video, as it was streamed";
  json["camera"] = camera_name_;
  json["codec"] = "VP8 in WebM";
  json["first_picture_at"] = first_at;
  json["duration_s"] = seconds;
  json["num_pictures"] = ended.num_pictures;
  json["poses"] = "one line a picture; ct_from_camera: mm, upper three rows, row by row";
  json["ended"] = ended.how;
  json["calibration"] = evidence::to_json(*calibration_());
  json["registered_to"] = evidence::skin_words(skin_());
  json["sha256"] = {{name + ".webm", video_hash}, {name + ".jsonl", lines_hash}};
  MOR_CHECK(write_file(folder_ / (name + ".json"), json.dump(2) + "\n"));
  return seconds;
}

/// The JSON comes first: where it is missing, the video still has `.part` in its name.
Result<double> Recorder::finish_files(const std::string& name,
                                      const std::string& how,
                                      bool is_broken) const {
  const VideoFiles part = part_files(folder_, name);
  const VideoFiles whole{folder_ / (name + ".webm"), folder_ / (name + ".jsonl")};
  const auto moved = [](const fs::path& from, const fs::path& to) -> Result<void> {
    std::error_code status;
    fs::rename(from, to, status);
    if (!status) return {};
    return make_error(ErrorCode::kIo, fmt::format("{}: {}", to.string(), status.message()));
  };
  std::error_code status_of_file;
  if (fs::file_size(part.video, status_of_file) == 0) {
    fs::remove(part.video, status_of_file);
    fs::remove(part.pictures, status_of_file);
    return make_error(ErrorCode::kIo,
                      "no picture came while the video was recorded: there is none");
  }
  if (!is_broken) {
    const auto num_pictures = status().video.num_pictures;
    MOR_TRY(const double seconds,
            write_evidence(name, {part.video, part.pictures, num_pictures, how}));
    MOR_CHECK(moved(part.pictures, whole.pictures));
    MOR_CHECK(moved(part.video, whole.video));
    return seconds;
  }
  const VideoFiles repaired{folder_ / (name + ".repair.webm"), folder_ / (name + ".repair.jsonl")};
  MOR_TRY(const auto num_pictures, repair_video(part.video, repaired.video));
  // Where they were moved already when the program ended, the video alone is unfinished.
  std::error_code is_missing;
  const auto& lines = fs::exists(part.pictures, is_missing) ? part.pictures : whole.pictures;
  MOR_CHECK(write_lines(lines, repaired.pictures, num_pictures));
  MOR_TRY(const double seconds,
          write_evidence(name, {repaired.video, repaired.pictures, num_pictures, how}));
  MOR_CHECK(moved(repaired.pictures, whole.pictures));
  MOR_CHECK(moved(repaired.video, whole.video));
  std::error_code status;
  fs::remove(part.video, status);
  fs::remove(part.pictures, status);
  return seconds;
}

void Recorder::finish(const std::string& name, const std::string& problem, bool is_left_over) {
  const std::string how =
      is_left_over      ? "with the program, which was stopped; repaired when it was started again"
      : problem.empty() ? "by the user"
                        : problem;
  const auto seconds = finish_files(name, how, is_left_over || !problem.empty());
  std::string said;
  if (!seconds) {
    std::error_code status;
    const bool is_there = fs::exists(part_files(folder_, name).video, status);
    said = fmt::format("{}.", problem.empty() ? seconds.error().message : problem);
    if (is_there) said += fmt::format(" The video so far stays in {}.part.webm.", name);
  } else if (is_left_over) {
    said = fmt::format("{}.webm was left unfinished; it is repaired, {:.0f} s.", name, *seconds);
  } else if (!problem.empty()) {
    said = fmt::format("{}. {}.webm has {:.0f} s.", problem, name, *seconds);
  } else {
    said = fmt::format("Saved {}.webm, {:.0f} s.", name, *seconds);
  }
  log::info("{}", said);
  const std::lock_guard lock(mutex_);
  status_.last_failed = !seconds || !problem.empty();
  status_.last_said = std::move(said);
  // A new one may have begun meanwhile.
  if (is_left_over && seconds && status_.state == RecorderState::kIdle) status_.name = name;
}

}  // namespace mor
