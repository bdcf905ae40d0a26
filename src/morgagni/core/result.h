// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace mor {

enum class ErrorCode : std::uint8_t {
  kInvalidArgument,  ///< The caller's value is wrong; the message names it and its limit.
  kNotFound,
  kIo,
  kUnsupported,
  kDevice,  ///< A GPU, camera or display failed.
  kTimeout,
  kCancelled,
  kInternal,
};

/// What went wrong, in one sentence a user can act on: what, which value, which limit.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
};

/// A value, or the sentence that says why there is none. Anything met in the field returns this.
template <class T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> make_error(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace mor

#define MOR_CONCAT_INNER(a, b) a##b
#define MOR_CONCAT(a, b) MOR_CONCAT_INNER(a, b)

/// `MOR_TRY(const auto mesh, read_ply(path));` gives the value or returns the error.
#define MOR_TRY(declaration, expression) \
  MOR_TRY_INNER(MOR_CONCAT(mor_try_, __LINE__), declaration, expression)
#define MOR_TRY_INNER(name, declaration, expression)                       \
  auto name = (expression);                                                \
  if (!name) return tl::unexpected<::mor::Error>(std::move(name).error()); \
  declaration = *std::move(name)

/// The same for a `Result<void>`: `MOR_CHECK(options.check());`
#define MOR_CHECK(expression)                                  \
  if (auto mor_check_result = (expression); !mor_check_result) \
  return tl::unexpected<::mor::Error>(std::move(mor_check_result).error())
