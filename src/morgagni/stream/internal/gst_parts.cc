// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/internal/gst_parts.h"

#include <array>

#include "morgagni/stream/internal/gst_handles.h"

namespace mor::internal {

namespace {

struct Part {
  const char* element;
  const char* package;
};

// webrtcbin makes the last five by itself, and fails late and obscurely where one is missing.
constexpr std::array kParts{
    Part{"appsrc", "gstreamer1.0-plugins-base"},
    Part{"vp8enc", "gstreamer1.0-plugins-good"},
    Part{"rtpvp8pay", "gstreamer1.0-plugins-good"},
    Part{"rtpbin", "gstreamer1.0-plugins-good"},
    Part{"webrtcbin", "gstreamer1.0-plugins-bad"},
    Part{"dtlssrtpenc", "gstreamer1.0-plugins-bad"},
    Part{"srtpenc", "gstreamer1.0-plugins-bad"},
    Part{"sctpenc", "gstreamer1.0-plugins-bad"},
    Part{"nicesink", "gstreamer1.0-nice"},
};

}  // namespace

std::string missing_part(const std::string& element, const std::string& package) {
  const GstHandle<GstElementFactory> factory(gst_element_factory_find(element.c_str()));
  if (factory) return {};
  return "GStreamer has no " + element + ": install the Debian package " + package;
}

Result<void> check_gstreamer() {
  GError* raw_error = nullptr;
  if (!gst_init_check(nullptr, nullptr, &raw_error)) {
    const GErrorHandle error(raw_error);
    return make_error(ErrorCode::kDevice,
                      std::string("GStreamer does not start: ") +
                          (error ? error->message : "it gives no reason"));
  }
  for (const Part& part : kParts) {
    if (auto sentence = missing_part(part.element, part.package); !sentence.empty()) {
      return make_error(ErrorCode::kDevice, std::move(sentence));
    }
  }
  return {};
}

Result<GstElement*> add_part(GstBin* bin, const char* element) {
  GstElement* part = gst_element_factory_make(element, nullptr);
  if (part == nullptr) {
    return make_error(ErrorCode::kDevice, std::string("GStreamer cannot make ") + element);
  }
  gst_bin_add(bin, part);
  return part;
}

}  // namespace mor::internal
