// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "morgagni/core/result.h"

namespace mor::internal {

/// The boundary of a Content-Type "multipart/related; boundary=...". @errors kIo: it is another
/// type, or its boundary is not 1 to 70 characters.
[[nodiscard]] Result<std::string> multipart_boundary(const std::string& content_type);

/// Where a part goes. Each may end the reading by an error.
struct PartSink {
  std::function<Result<void>()> begin;
  std::function<Result<void>(std::string_view)> data;
  std::function<Result<void>()> end;
};

/// Takes a multipart body apart as it comes (RFC 2046): parts go on without being kept, whatever
/// their size; heads of parts are bounded.
class MultipartReader {
 public:
  MultipartReader(const std::string& boundary, PartSink sink);

  /// @errors kIo: it is no multipart; the sink's.
  [[nodiscard]] Result<void> feed(std::string_view bytes);
  /// After the last bytes. @errors kIo: it ends within a part.
  [[nodiscard]] Result<void> finish() const;

 private:
  enum class State : unsigned char { kPreamble, kDelimiter, kHead, kBody, kEpilogue };

  /// Each goes one step on; false: it needs more bytes.
  Result<bool> find_body_end(bool in_part);
  Result<bool> pass_delimiter();
  Result<bool> pass_head();

  std::string delimiter_;  ///< With the line's end before it.
  PartSink sink_;
  State state_ = State::kPreamble;
  std::string pending_;
};

}  // namespace mor::internal
