// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/result.h"

namespace mor::internal {

/// One `key=value` of a camera's name.
struct KeyValue {
  std::string_view key;
  std::string_view value;
};

/// Splits `a=1,b=2`; an empty text has none. @errors kInvalidArgument: a part without `=`.
[[nodiscard]] Result<std::vector<KeyValue>> split_key_values(std::string_view text);

/// @errors kInvalidArgument: no whole number, or outside [least, most]; names the key.
[[nodiscard]] Result<std::uint64_t> parse_count(const KeyValue& pair,
                                                std::uint64_t least,
                                                std::uint64_t most);

/// @errors kInvalidArgument: no finite number, or outside [least, most]; names the key.
[[nodiscard]] Result<double> parse_number(const KeyValue& pair, double least, double most);

/// Which of `allowed` the value is. @errors kInvalidArgument: none of them; names them.
[[nodiscard]] Result<std::size_t> parse_choice(const KeyValue& pair,
                                               const std::vector<std::string_view>& allowed);

/// `device=ID`. @errors kInvalidArgument: no id; see check_device_id().
[[nodiscard]] Result<std::string> parse_device_id(const KeyValue& pair);

/// The sentence for a key that `camera` does not know.
[[nodiscard]] tl::unexpected<Error> unknown_key(std::string_view camera,
                                                const KeyValue& pair,
                                                const std::vector<std::string_view>& allowed);

}  // namespace mor::internal
