// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace mor::testing_files {

/// How the numbers of a VTP file are written.
struct VtpStyle {
  std::string format = "ascii";  ///< "ascii", "binary", "appended".
  std::string encoding = "raw";  ///< Of what is appended: "raw", "base64".
  bool compressed = false;
  bool wide_heads = false;
  bool big_endian = false;
};

/// A box from (10, 20, 30) to (14, 26, 38) of four-cornered polygons and one strip.
[[nodiscard]] std::string box_vtp_file(const VtpStyle& style);

}  // namespace mor::testing_files
