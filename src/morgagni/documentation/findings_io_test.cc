// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/findings_io.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class FindingsIo : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_.parent_path());
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "findings_io_test" / "findings";
};

Finding a_point(const std::string& id) {
  Finding finding;
  finding.id = id;
  finding.note = "Bruise, 3 × 2 cm\n\"left\" <b>side</b>";
  finding.points = {{.ct_mm = {1.25, -200.125, 1e-7}, .is_on_skin = true, .bound_mm = 1.5}};
  finding.created_at = "2026-11-26T16:20:05Z";
  finding.photo = "F1.png";
  return finding;
}

Finding a_geodesic(const std::string& id) {
  Finding finding = a_point(id);
  finding.kind = FindingKind::kGeodesic;
  finding.points.push_back({.ct_mm = {3, 4, 5}, .is_on_skin = false, .bound_mm = std::nullopt});
  finding.path_ct_mm = {{1, 2, 3}, {2, 3, 4}, {3, 4, 5}};
  finding.length_mm = 3.4641016151377544;
  return finding;
}

TEST_F(FindingsIo, AFolderWithoutFindingsHasNone) {
  EXPECT_TRUE(read_findings(folder_)->empty());
  EXPECT_EQ(last_finding_number(folder_).value(), 0);
}

TEST_F(FindingsIo, GivesBackWhatWasWritten) {
  ASSERT_TRUE(write_findings(folder_, {a_point("F1"), a_geodesic("F2")}));
  const auto read = read_findings(folder_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  const Finding& first = read->front();
  EXPECT_EQ(first.id, "F1");
  EXPECT_EQ(first.note, a_point("F1").note);
  EXPECT_EQ(first.points[0].ct_mm, a_point("F1").points[0].ct_mm) << "bit for bit";
  EXPECT_EQ(first.points[0].bound_mm, 1.5);
  EXPECT_EQ(first.created_at, "2026-11-26T16:20:05Z");
  EXPECT_EQ(first.photo, "F1.png");
  const Finding& second = read->back();
  EXPECT_EQ(second.kind, FindingKind::kGeodesic);
  EXPECT_FALSE(second.points[1].is_on_skin);
  EXPECT_FALSE(second.points[1].bound_mm);
  EXPECT_EQ(second.path_ct_mm, a_geodesic("F2").path_ct_mm);
  EXPECT_EQ(second.length_mm, a_geodesic("F2").length_mm);
  EXPECT_FALSE(second.length_bound_mm);
}

TEST_F(FindingsIo, ANumberIsNeverUsedTwice) {
  ASSERT_TRUE(write_findings(folder_, {a_point("F1"), a_point("F7")}));
  ASSERT_TRUE(write_findings(folder_, {a_point("F1")}));
  ASSERT_TRUE(write_findings(folder_, {}));
  EXPECT_EQ(last_finding_number(folder_).value(), 7);
}

TEST_F(FindingsIo, RefusesHostileNotes) {
  EXPECT_THAT(check_note(std::string(4001, 'a')).error().message, HasSubstr("4000 bytes"));
  EXPECT_THAT(check_note("a\x1b[31m").error().message, HasSubstr("U+001B"));
  EXPECT_THAT(check_note(std::string("a\0b", 3)).error().message, HasSubstr("U+0000"));
  EXPECT_THAT(check_note("abc\xE2\x80\xAE"
                         "def")
                  .error()
                  .message,
              HasSubstr("U+202E"));
  for (const char* const text :
       {"\xC0\xAF", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\xE2\x82", "\xFF"})
    EXPECT_THAT(check_note(text).error().message, HasSubstr("UTF-8"));
  EXPECT_TRUE(check_note("Größe\t3 × 2 cm\n<script>alert(1)</script> 🫀"));
}

TEST_F(FindingsIo, RefusesWhatIsNoFinding) {
  const auto refused = [](auto change) {
    Finding finding = a_geodesic("F3");
    change(finding);
    const auto result = check_finding(finding);
    return result ? std::string() : result.error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused([](Finding&) {}), "");
  EXPECT_THAT(refused([](Finding& f) { f.id = "F03"; }), HasSubstr("id"));
  EXPECT_THAT(refused([](Finding& f) { f.id = "F0"; }), HasSubstr("id"));
  EXPECT_THAT(refused([](Finding& f) { f.id = "<img>"; }), HasSubstr("id"));
  EXPECT_THAT(refused([&](Finding& f) { f.points[0].ct_mm.y() = nan; }), HasSubstr("coordinates"));
  EXPECT_THAT(refused([&](Finding& f) { f.path_ct_mm[1].z() = 1e9; }), HasSubstr("coordinates"));
  EXPECT_THAT(refused([&](Finding& f) { f.points[0].bound_mm = nan; }), HasSubstr("coordinates"));
  EXPECT_THAT(refused([](Finding& f) { f.points.pop_back(); }), HasSubstr("has 2 point(s), got 1"));
  EXPECT_THAT(refused([](Finding& f) { f.length_mm = -1.0; }), HasSubstr("lengths"));
  EXPECT_THAT(refused([](Finding& f) { f.photo = "../../etc/passwd"; }), HasSubstr("photo"));
  EXPECT_THAT(refused([](Finding& f) { f.path_ct_mm.resize(100'001); }), HasSubstr("100000"));
}

TEST_F(FindingsIo, KeepsTheOldFileWhenTheNewListIsRefused) {
  ASSERT_TRUE(write_findings(folder_, {a_point("F1")}));
  const auto twice = write_findings(folder_, {a_point("F2"), a_point("F2")});
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error().message, HasSubstr("two findings F2"));
  std::vector<Finding> many;
  for (std::size_t i = 1; i <= kMaxFindings + 1; ++i)
    many.push_back(a_point(fmt::format("F{}", i)));
  const auto too_many = write_findings(folder_, many);
  ASSERT_FALSE(too_many);
  EXPECT_THAT(too_many.error().message, HasSubstr("up to 2000 findings, there are 2001"));
  EXPECT_EQ(read_findings(folder_)->size(), 1U);
}

TEST_F(FindingsIo, SaysWhatIsDamagedAndNeverWritesOverIt) {
  fs::create_directories(folder_);
  const std::string start = R"({"format": 1, "findings": )";
  for (const std::string& text :
       {std::string("not json"),
        std::string(R"({"findings": []})"),
        start + "3}",
        start + R"([{"id": "F1"}]})",
        start + R"([{"id": "F1", "kind": "point", "note": "", "points": [{"ct_mm": [1, 2, "3"],
                   "on_skin": true}]}]})",
        start + R"([{"id": "F1", "kind": "point", "note": "", "points": [{"ct_mm": [1, 2, 1e300],
                   "on_skin": true}]}]})"}) {
    ASSERT_TRUE(write_file(folder_ / kFindingsFile, text));
    const auto read = read_findings(folder_);
    ASSERT_FALSE(read) << text;
    EXPECT_THAT(read.error().message, HasSubstr("damaged"));
    EXPECT_FALSE(write_findings(folder_, {a_point("F1")}));
    EXPECT_EQ(read_text_file(folder_ / kFindingsFile, 1000).value(), text);
  }
  ASSERT_TRUE(write_file(folder_ / kFindingsFile, R"({"format": 2, "findings": []})"));
  EXPECT_THAT(read_findings(folder_).error().message, HasSubstr("newer Morgagni"));
}

TEST_F(FindingsIo, SaysWhereItCannotWrite) {
  ASSERT_TRUE(write_file(folder_, "a file where the folder should be"));
  const auto refused = write_findings(folder_, {a_point("F1")});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr(folder_.string()));
}

}  // namespace
}  // namespace mor
