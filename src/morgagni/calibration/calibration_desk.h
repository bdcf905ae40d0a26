// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "morgagni/calibration/calibration_store.h"
#include "morgagni/calibration/view_collector.h"
#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/stream/live_server.h"

namespace mor {

struct CalibrationDeskOptions {
  CalibrationBoard board;
  CollectorOptions collector;
  RigOptions rig;
  std::string device_id;  ///< Under which the result is kept. Empty: the camera's own.
  CalibrationStore store;
  LiveServerOptions server;
};

/// A calibration on a page (web/calibrate.html): the live picture with the board found in it, what
/// is still missing in words, and then the result, to be kept or thrown away. Routes under
/// /api/calibration, the state as server-sent events (docs/http-api.md).
class CalibrationDesk {
 public:
  /// @errors As the server's.
  [[nodiscard]] static Result<std::unique_ptr<CalibrationDesk>> start(
      std::unique_ptr<RangeCamera> camera, const CalibrationDeskOptions& options);
  virtual ~CalibrationDesk() = default;
  [[nodiscard]] virtual std::uint16_t port() const = 0;
};

}  // namespace mor
