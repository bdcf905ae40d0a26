// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "morgagni/camera/range_camera.h"

namespace mor {

struct WatchOptions {
  std::chrono::milliseconds silence{700};  ///< Without a good frame for so long, it is said. > 0.
  std::chrono::milliseconds retry{400};    ///< From one try to open the device to the next. > 0.
  std::chrono::milliseconds give_up{
      2000};                ///< A driver that hangs for so long is left behind. > 0.
  int max_left_behind = 4;  ///< So many hanging drivers at most; then it is waited for one. >= 1.

  [[nodiscard]] Result<void> check() const;
};

/// Opens the device that is watched. May be called from another thread each time, and must not
/// outlive what it refers to by much: a driver that hangs may call it late.
using CameraOpener = std::function<Result<std::unique_ptr<RangeCamera>>()>;

/// Puts a device behind a watch: it runs in a thread of its own, and whoever asks for a frame gets
/// one, or within `silence` the reason why there is none. A device that fails, hangs, or sends
/// garbage (pictures of another size, captured in the future or before the last one) is closed and
/// opened anew, until it is back.
/// @return Opened once already. @errors As the opener's, kInvalidArgument (options).
[[nodiscard]] Result<std::unique_ptr<RangeCamera>> watch_camera(CameraOpener open,
                                                                const WatchOptions& options = {});

}  // namespace mor
