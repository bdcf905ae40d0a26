// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"

namespace mor {

/// A calibration of one device, as it was found one day.
struct KeptCalibration {
  std::string device_id;  ///< RangeCamera::device_id(); of letters, digits, '-', '_', '.' alone.
  std::chrono::system_clock::time_point made_at;  ///< To the second.
  std::string made_by;                            ///< "board", or in words how it was found.
  /// What it is worth, in words for people and in the order they are read.
  std::vector<std::pair<std::string, std::string>> figures;
  RgbdCalibration calibration;
};

/// Calibrations by device, each in a file of its own; none is ever overwritten.
class CalibrationStore {
 public:
  /// $MORGAGNI_CAMERAS_DIR, else $XDG_DATA_HOME/morgagni/cameras, else
  /// ~/.local/share/morgagni/cameras.
  [[nodiscard]] static std::filesystem::path default_folder();

  explicit CalibrationStore(std::filesystem::path folder = default_folder())
      : folder_(std::move(folder)) {}

  /// Keeps it beside the older ones; its `calibration.origin` says from now on how it was found and
  /// when. @return Its file. @errors kInvalidArgument: no usable id; kIo.
  [[nodiscard]] Result<std::filesystem::path> save(KeptCalibration kept) const;

  /// Takes back what save() kept: the one before it is the newest again.
  /// @errors kInvalidArgument: no file of this store; kIo.
  [[nodiscard]] Result<void> take_back(const std::filesystem::path& file) const;

  /// The newest one of a device that can be read; a damaged file is said in the log and passed
  /// over. None: there is none.
  [[nodiscard]] std::optional<KeptCalibration> newest(const std::string& device_id) const;

  /// The newest one of every device, by id.
  [[nodiscard]] std::vector<KeptCalibration> list() const;

  /// For open_camera(): the newest one, where its pictures have the size of the device's.
  [[nodiscard]] KnownCalibration known() const;

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

/// @errors kInvalidArgument: no JSON of a kept calibration; names the member.
[[nodiscard]] Result<KeptCalibration> kept_calibration_from_json(std::string_view text);
[[nodiscard]] std::string to_json(const KeptCalibration& kept);

/// "12 days old", "3 hours old", for people.
[[nodiscard]] std::string age_text(std::chrono::system_clock::duration age);

}  // namespace mor
