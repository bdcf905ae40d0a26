// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/core/xml_text.h"

#include <gtest/gtest.h>

namespace mor {
namespace {

TEST(XmlText, MarkupBecomesWords) {
  EXPECT_EQ(xml_text("a < b & \"c\" > d"), "a &lt; b &amp; &quot;c&quot; &gt; d");
}

TEST(XmlText, LinesAndTabsBecomeSpacesAndControlCharactersGo) {
  EXPECT_EQ(xml_text("one\ntwo\tthree\x01\x1b[0m"), "one two three[0m");
}

TEST(XmlText, KeepsEveryScript) {
  EXPECT_EQ(xml_text("Müller 头"), "Müller 头");
}

TEST(XmlText, BytesThatAreNoUtf8BecomeTheReplacementCharacter) {
  EXPECT_EQ(xml_text("a\xffz"), "a\xef\xbf\xbdz");
  EXPECT_EQ(valid_utf8("cut \xc3"), "cut \xef\xbf\xbd");
}

}  // namespace
}  // namespace mor
