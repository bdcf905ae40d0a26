// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <gst/gst.h>

#include "morgagni/core/glib_handles.h"

namespace mor {

template <class T>
using GstHandle = std::unique_ptr<T, FreeWith<gst_object_unref>>;
using GstCapsHandle = std::unique_ptr<GstCaps, FreeWith<gst_caps_unref>>;
using GstBufferHandle = std::unique_ptr<GstBuffer, FreeWith<gst_buffer_unref>>;

}  // namespace mor
