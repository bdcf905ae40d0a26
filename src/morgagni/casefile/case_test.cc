// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/case.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/casefile/prepare.h"
#include "morgagni/casefile/testing/synthetic_ct.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// A prepared case to damage, made once.
class CaseTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    fs::remove_all(original());
    fs::create_directories(original().parent_path());
    const fs::path ct = original().string() + ".mha";
    testing_ct::write_synthetic_ct(ct);
    PrepareOptions options;
    options.skin.num_vertices = 500;
    options.bone.num_triangles = 500;
    const auto made = prepare_case(ct, original(), options, [](std::string_view, double) {});
    ASSERT_TRUE(made) << made.error().message;
  }

  void SetUp() override {
    fs::remove_all(folder_);
    fs::copy(original(), folder_, fs::copy_options::recursive);
  }

  static fs::path original() { return fs::path(testing::TempDir()) / "case_test_original"; }

  void edit(const std::function<void(nlohmann::json&)>& change) const {
    auto json = nlohmann::json::parse(read_text_file(folder_ / kCaseFile, 1U << 20U).value());
    change(json);
    ASSERT_TRUE(write_file(folder_ / kCaseFile, json.dump()));
  }

  std::string message() const {
    const auto loaded = load_case(folder_);
    return loaded ? "it loaded" : loaded.error().message;
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "case_test_copy";
};

TEST_F(CaseTest, SaysHowToMakeACaseWhereThereIsNone) {
  fs::remove(folder_ / kCaseFile);
  EXPECT_THAT(message(), AllOf(HasSubstr("no prepared case"), HasSubstr("morgagni prepare")));
  fs::remove_all(folder_);
  EXPECT_THAT(message(), AllOf(HasSubstr("no such case folder"), HasSubstr("morgagni prepare")));
}

TEST_F(CaseTest, NoticesADamagedFile) {
  auto bytes = read_file(folder_ / "bone.ply", 1U << 26U).value();
  bytes[bytes.size() / 2] ^= std::byte{1};
  ASSERT_TRUE(write_file(folder_ / "bone.ply", bytes));
  EXPECT_THAT(message(), HasSubstr("bone.ply does not match its hash"));
}

TEST_F(CaseTest, NoticesAMissingFile) {
  fs::remove(folder_ / "skin.field");
  EXPECT_THAT(message(), HasSubstr("skin.field"));
}

TEST_F(CaseTest, LoadsACaseThatWasMadeBeforeVolumesWereKept) {
  fs::remove(folder_ / "body.volume");
  EXPECT_THAT(message(), HasSubstr("body.volume"));
  edit([](auto& json) { json["files"].erase("body.volume"); });
  const auto loaded = load_case(folder_);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->volume, nullptr);
}

TEST_F(CaseTest, RefusesTextThatIsNoCase) {
  for (const char* text : {"", "{", "[]", "{}", R"({"format": "1"})", R"({"format": 0})"}) {
    ASSERT_TRUE(write_file(folder_ / kCaseFile, text));
    EXPECT_THAT(message(), HasSubstr("damaged")) << text;
  }
}

TEST_F(CaseTest, RefusesANewerFormat) {
  edit([](auto& json) { json["format"] = 99; });
  EXPECT_THAT(message(), HasSubstr("format 99"));
}

TEST_F(CaseTest, ReadsNoFileOutsideOfItsFolder) {
  edit([](auto& json) { json["structures"][0]["file"] = "../case_test_original/bone.ply"; });
  EXPECT_THAT(message(), HasSubstr("no file name"));
}

TEST_F(CaseTest, RefusesMembersOfAnotherKind) {
  edit([](auto& json) { json["structures"] = "bone"; });
  EXPECT_THAT(message(), HasSubstr("damaged"));
  edit([](auto& json) { json["structures"] = nlohmann::json::array({1}); });
  EXPECT_THAT(message(), HasSubstr("damaged"));
  edit([](auto& json) { json["ct"]["center_mm"] = {1, 2}; });
  EXPECT_THAT(message(), HasSubstr("center_mm"));
  edit([](auto& json) { json["files"] = nullptr; });
  EXPECT_THAT(message(), HasSubstr("damaged"));
}

}  // namespace
}  // namespace mor
