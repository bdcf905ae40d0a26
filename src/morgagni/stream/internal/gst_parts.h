// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <gst/gst.h>

#include "morgagni/core/result.h"

namespace mor::internal {

/// Initialises GStreamer and looks for every plug-in that the stream needs.
/// @errors kDevice: names the plug-in that is missing and the Debian package that has it.
[[nodiscard]] Result<void> check_gstreamer();

/// The sentence about a missing element; empty when it is there.
[[nodiscard]] std::string missing_part(const std::string& element, const std::string& package);

/// Makes an element inside `bin`, which owns it. @errors kDevice: there is none of that name.
[[nodiscard]] Result<GstElement*> add_part(GstBin* bin, const char* element);

}  // namespace mor::internal
