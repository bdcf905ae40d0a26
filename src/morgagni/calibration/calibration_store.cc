// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/calibration/calibration_store.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/camera/calibration_json.h"
#include "morgagni/camera/device_id.h"
#include "morgagni/core/files.h"
#include "morgagni/core/log.h"
#include "morgagni/core/utc.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using std::chrono::system_clock;

constexpr std::uintmax_t kMaxBytes = 4U << 20U;

tl::unexpected<Error> bad(std::string message) {
  return make_error(ErrorCode::kInvalidArgument, "kept calibration: " + std::move(message));
}

Result<std::string> text_of(const Json& json, const char* key) {
  const auto value = json.find(key);
  if (value == json.end() || !value->is_string()) return bad(fmt::format("has no text {}", key));
  return value->get<std::string>();
}

/// The files of one device, newest first.
std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(folder, status)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::ranges::sort(files, std::ranges::greater());
  return files;
}

std::optional<KeptCalibration> newest_in(const fs::path& folder) {
  for (const auto& file : files_of(folder)) {
    const auto text = read_text_file(file, kMaxBytes);
    auto kept = text ? kept_calibration_from_json(*text)
                     : Result<KeptCalibration>(tl::unexpect, text.error());
    if (kept) return *std::move(kept);
    log::warn("{} is passed over: {}", file.string(), kept.error().message);
  }
  return std::nullopt;
}

bool has_sizes_of(const RgbdCalibration& a, const RgbdCalibration& b) {
  return a.depth.width_px == b.depth.width_px && a.depth.height_px == b.depth.height_px &&
         a.color.width_px == b.color.width_px && a.color.height_px == b.color.height_px;
}

}  // namespace

fs::path CalibrationStore::default_folder() {
  const auto variable = [](const char* name) -> std::optional<fs::path> {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == '\0') return std::nullopt;
    return value;
  };
  if (const auto folder = variable("MORGAGNI_CAMERAS_DIR")) return *folder;
  if (const auto data = variable("XDG_DATA_HOME")) return *data / "morgagni" / "cameras";
  return variable("HOME").value_or("/") / ".local" / "share" / "morgagni" / "cameras";
}

Result<fs::path> CalibrationStore::save(KeptCalibration kept) const {
  MOR_CHECK(check_device_id(kept.device_id));
  const auto stamp = utc_text(kept.made_at);
  kept.calibration.origin = fmt::format("{}, {}", kept.made_by, stamp);
  const auto folder = folder_ / kept.device_id;
  std::error_code status;
  fs::create_directories(folder, status);
  if (status) {
    return make_error(ErrorCode::kIo, fmt::format("{}: {}", folder.string(), status.message()));
  }
  std::string name = stamp;
  std::ranges::replace(name, ':', '-');
  auto file = folder / (name + ".json");
  // '_' sorts after '.': the later of two in one second is the newer one.
  for (int i = 2; fs::exists(file); ++i) file = folder / fmt::format("{}_{}.json", name, i);
  MOR_CHECK(write_file(file, to_json(kept)));
  return file;
}

std::optional<KeptCalibration> CalibrationStore::newest(const std::string& device_id) const {
  if (!check_device_id(device_id)) return std::nullopt;
  return newest_in(folder_ / device_id);
}

Result<void> CalibrationStore::take_back(const fs::path& file) const {
  std::error_code status;
  if (file.extension() != ".json" ||
      file.parent_path().parent_path() != (folder_ / "").parent_path()) {
    return bad(fmt::format("{} is none", file.string()));
  }
  if (fs::remove(file, status) && !status) return {};
  return make_error(
      ErrorCode::kIo,
      fmt::format("{}: {}", file.string(), status ? status.message() : "it is not there any more"));
}

std::vector<KeptCalibration> CalibrationStore::list() const {
  std::vector<KeptCalibration> kept;
  std::error_code status;
  for (const auto& entry : fs::directory_iterator(folder_, status)) {
    if (auto newest = newest_in(entry.path())) kept.push_back(*std::move(newest));
  }
  std::ranges::sort(kept, {}, &KeptCalibration::device_id);
  return kept;
}

KnownCalibration CalibrationStore::known() const {
  return
      [store = *this](const std::string& device_id,
                      const RgbdCalibration& by_design) -> Result<std::optional<RgbdCalibration>> {
        auto kept = store.newest(device_id);
        if (!kept) return std::nullopt;
        if (!has_sizes_of(kept->calibration, by_design)) {
          log::warn("the calibration kept for {} is for pictures of another size and is not used",
                    device_id);
          return std::nullopt;
        }
        log::info("{} is calibrated: {}", device_id, kept->calibration.origin);
        return std::move(kept->calibration);
      };
}

std::string to_json(const KeptCalibration& kept) {
  Json figures = Json::object();
  for (const auto& [name, value] : kept.figures) figures[name] = value;
  return Json{{"device_id", kept.device_id},
              {"made_at", utc_text(kept.made_at)},
              {"made_by", kept.made_by},
              {"figures", figures},
              {"calibration", Json::parse(calibration_to_json(kept.calibration))}}
             .dump(1) +
         "\n";
}

Result<KeptCalibration> kept_calibration_from_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return bad("is no JSON object");
  KeptCalibration kept;
  MOR_TRY(kept.device_id, text_of(json, "device_id"));
  MOR_CHECK(check_device_id(kept.device_id));
  MOR_TRY(const auto made_at, text_of(json, "made_at"));
  MOR_TRY(kept.made_at, parse_utc(made_at));
  MOR_TRY(kept.made_by, text_of(json, "made_by"));
  if (const auto figures = json.find("figures"); figures != json.end() && figures->is_object()) {
    for (const auto& [name, value] : figures->items()) {
      if (value.is_string()) kept.figures.emplace_back(name, value.get<std::string>());
    }
  }
  const auto calibration = json.find("calibration");
  if (calibration == json.end()) return bad("has no calibration");
  MOR_TRY(kept.calibration, calibration_from_json(calibration->dump()));
  return kept;
}

std::string age_text(system_clock::duration age) {
  const auto hours = std::chrono::duration_cast<std::chrono::hours>(age).count();
  if (hours < 1) return "less than an hour old";
  if (hours < 48) return fmt::format("{} hour{} old", hours, hours == 1 ? "" : "s");
  return fmt::format("{} days old", hours / 24);
}

}  // namespace mor
