// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/printable_text.h"

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(PrintableText, KeepsWhatIsGood) {
  EXPECT_EQ(printable_text(""), "");
  EXPECT_EQ(printable_text("skull 3 mm"), "skull 3 mm");
  EXPECT_EQ(printable_text("Sch\u00e4del \u982d\u90e8"), "Sch\u00e4del \u982d\u90e8");
}

TEST(PrintableText, TakesOtherBytesForLatin1) {
  EXPECT_EQ(printable_text("Sch\xe4"
                           "del"),
            "Sch\u00e4del");
  EXPECT_EQ(printable_text("\xff"), "\u00ff");
  EXPECT_EQ(printable_text("\xc3("), "\u00c3(");
}

TEST(PrintableText, LeavesOutACharacterThatWasCut) {
  EXPECT_EQ(printable_text("Sch\xc3"), "Sch");
  EXPECT_EQ(printable_text("ab\xe9\xa0"), "ab");
}

TEST(PrintableText, HasNothingThatATerminalObeys) {
  EXPECT_EQ(printable_text("a\x1b[31mb\nc\td\x7f"), "a [31mb c d ");
  EXPECT_EQ(printable_text(std::string_view("a\0b", 3)), "a b");
  EXPECT_EQ(printable_text("a\u202e"
                           "b\u009b"),
            "a b ");
}

}  // namespace
}  // namespace mor
