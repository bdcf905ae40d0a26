// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mutation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace mor {
namespace {

class Mutation {
 public:
  Mutation(std::string bytes, std::mt19937& random) : bytes_(std::move(bytes)), random_(random) {}

  std::string result() && {
    const auto num_changes = 1 + below(8);
    for (std::size_t i = 0; i < num_changes && bytes_.size() > 8; ++i) change();
    if (below(10) == 0) bytes_.resize(below(bytes_.size()) + 1);
    return std::move(bytes_);
  }

 private:
  std::size_t below(std::size_t limit) {
    return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_);
  }

  void change() {
    const std::size_t at = below(bytes_.size() - 4);
    switch (below(7)) {
      case 0:
        bytes_[at] = static_cast<char>(below(256));
        break;
      case 1:
        bytes_[at] = static_cast<char>(bytes_[at] ^ (1 << below(8)));
        break;
      case 2:
        bytes_.erase(at, 1 + below(4));
        break;
      case 3:
        bytes_.insert(at, bytes_.substr(below(bytes_.size()), 1 + below(16)));
        break;
      case 4:
        overwrite(at, below(2) == 0 ? "\xff\xff\xff\xff" : "\x7f\xff\xff\x7f");
        break;
      default:
        replace_number(at);
        break;
    }
  }

  void overwrite(std::size_t at, std::string_view four) {
    std::copy(four.begin(), four.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  /// The next number in text from there.
  void replace_number(std::size_t at) {
    constexpr std::array<std::string_view, 10> kAbsurd = {"0",
                                                          "-1",
                                                          "1",
                                                          "65536",
                                                          "2147483648",
                                                          "4294967295",
                                                          "99999999999999999999",
                                                          "1e39",
                                                          "nan",
                                                          "-0.0"};
    const auto is_digit = [](unsigned char letter) { return std::isdigit(letter) != 0; };
    const auto begin =
        std::find_if(bytes_.begin() + static_cast<std::ptrdiff_t>(at), bytes_.end(), is_digit);
    const auto end = std::find_if_not(begin, bytes_.end(), is_digit);
    bytes_.replace(begin, end, kAbsurd[below(kAbsurd.size())]);
  }

  std::string bytes_;
  std::mt19937& random_;
};

}  // namespace

std::string mutated(std::string bytes, std::mt19937& random) {
  return Mutation(std::move(bytes), random).result();
}

}  // namespace mor
