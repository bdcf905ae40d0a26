// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "morgagni/camera/open_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/stream/live_server.h"

namespace mor {

/// Opens a camera; waits for a device that is not there yet, and says for what.
using OpenCamera =
    std::function<Result<std::unique_ptr<RangeCamera>>(std::stop_token, const SayWaiting&)>;

/// The camera, from a thread of its own. Ends the program where it cannot be opened.
/// @param say  Told on the calling thread what is waited for, where that takes longer than usual.
/// @return Null: stopped before.
[[nodiscard]] std::unique_ptr<RangeCamera> wait_for_camera(const OpenCamera& open,
                                                           const std::stop_token& stop,
                                                           const SayWaiting& say);

/// The same, while a page says what is waited for.
/// @param page_title  What the camera is for: the case's name.
/// @param path  Of the page, for the terminal.
/// @param server  Its port is the page's afterwards: what follows begins where the page is.
[[nodiscard]] std::unique_ptr<RangeCamera> wait_for_camera_on_page(const OpenCamera& open,
                                                                   const std::stop_token& stop,
                                                                   const std::string& page_title,
                                                                   const std::string& camera_name,
                                                                   const std::string& path,
                                                                   LiveServerOptions& server);

}  // namespace mor
