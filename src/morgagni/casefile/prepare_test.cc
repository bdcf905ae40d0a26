// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/casefile/prepare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/casefile/case.h"
#include "morgagni/casefile/testing/synthetic_ct.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const Progress kQuiet = [](std::string_view, double) {};

class PrepareTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(place_);
    fs::create_directories(place_);
    testing_ct::write_synthetic_ct(ct_);
  }

  PrepareOptions options() const {
    PrepareOptions options;
    options.skin.num_vertices = 2000;
    options.bone.num_triangles = 2000;
    return options;
  }

  const fs::path place_ = fs::path(testing::TempDir()) / "prepare_test";
  const fs::path ct_ = place_ / "egg.mha";
  const fs::path case_ = place_ / "case";
};

TEST_F(PrepareTest, MakesACaseThatLoads) {
  const auto summary = prepare_case(ct_, case_, options(), kQuiet);
  ASSERT_TRUE(summary) << summary.error().message;
  const auto body = load_case(case_);
  ASSERT_TRUE(body) << body.error().message;
  EXPECT_EQ(body->name, "case");
  EXPECT_EQ(body->folder, case_);
  EXPECT_EQ(body->ct_voxels_sha256.size(), 64U);
  EXPECT_EQ(body->skin->mesh.vertices.size(), summary->num_skin_vertices);
  EXPECT_NEAR(static_cast<double>(summary->num_skin_vertices), 2000.0, 60.0);
  ASSERT_EQ(body->structures.size(), 1U);
  EXPECT_EQ(body->structures[0].name, "bone");
}

TEST_F(PrepareTest, PutsSkinAndBoneWhereTheCtHasThem) {
  ASSERT_TRUE(prepare_case(ct_, case_, options(), kQuiet));
  const auto body = load_case(case_).value();
  const Eigen::Vector3d middle =
      testing_ct::kOriginMm +
      Eigen::Vector3d::Constant(0.5 * testing_ct::kSpacingMm * (testing_ct::kSide - 1));
  EXPECT_LT((body.ct_center_mm - middle).norm(), 1e-9);
  const auto bone = body.structures[0].mesh.bounds();
  EXPECT_LT((bone.center().cast<double>() - (middle + Eigen::Vector3d(10, 0, 5))).norm(), 1.0);
  EXPECT_LT((bone.sizes().cast<double>() - Eigen::Vector3d(50, 50, 60)).norm(), 3.0);
  const auto skin = body.skin->mesh.bounds();
  EXPECT_NEAR(skin.min().y(), middle.y() - 82.0, 1.5) << "the nose points to the front";
  EXPECT_NEAR(skin.max().x(), middle.x() + 69.0, 1.5) << "the larger ear is on the left";
}

TEST_F(PrepareTest, KeepsTheVoxelsOfTheBodyWhereTheCtHasThem) {
  ASSERT_TRUE(prepare_case(ct_, case_, options(), kQuiet));
  const auto volume = load_case(case_).value().volume;
  ASSERT_NE(volume, nullptr);
  EXPECT_LT(volume->num_voxels(), std::size_t{testing_ct::kSide} * testing_ct::kSide * 90);
  std::size_t num_inside = 0;
  for (int z = 0; z < volume->size[2]; ++z) {
    for (int y = 0; y < volume->size[1]; ++y) {
      for (int x = 0; x < volume->size[0]; ++x) {
        const std::int16_t hu = volume->hu[volume->index(x, y, z)];
        const Eigen::Vector3d in_grid = volume->spacing_mm.cwiseProduct(Eigen::Vector3d(x, y, z));
        const std::int16_t truth = testing_ct::hu_at(volume->ct_from_grid * in_grid);
        if (hu == kOutsideHu) {
          ASSERT_EQ(truth, -1000);
        } else {
          ASSERT_EQ(hu, truth);
          ++num_inside;
        }
      }
    }
  }
  EXPECT_GT(num_inside, 100000U);
}

TEST_F(PrepareTest, WritesAllOptionsAndTheIdentityOfTheCt) {
  ASSERT_TRUE(prepare_case(ct_, case_, options(), kQuiet));
  const auto json = nlohmann::json::parse(read_text_file(case_ / kCaseFile, 1U << 20U).value());
  EXPECT_EQ(json["options"]["skin"]["num_vertices"], 2000);
  EXPECT_EQ(json["options"]["skin"]["threshold_hu"], -300.0);
  EXPECT_EQ(json["options"]["bone"]["threshold_hu"], 250.0);
  EXPECT_EQ(json["ct"]["source"], "egg.mha");
  EXPECT_EQ(json["ct"]["voxels_sha256"].get<std::string>().size(), 64U);
  EXPECT_EQ(json["files"].size(), 5U);
}

TEST_F(PrepareTest, TakesStructuresFromLabelMaps) {
  const auto write_labels = [&](const std::string& name, const std::string& offset) {
    std::string bytes = "ObjectType = Image\nNDims = 3\nBinaryData = True\nOffset = " + offset +
                        "\nElementSpacing = 4 4 4\nDimSize = 20 20 20\nElementType = MET_UCHAR\n"
                        "ElementDataFile = LOCAL\n";
    for (int i = 0; i < 8000; ++i)
      bytes += static_cast<char>(i % 20 > 4 && i % 20 < 9 ? 5 : i % 20 > 12 ? 7 : 0);
    EXPECT_TRUE(write_file(place_ / name, bytes));
    return place_ / name;
  };
  auto with_labels = options();
  with_labels.label_maps = {write_labels("organs.mha", "-40 -60 90"),
                            write_labels("again.mha", "-40 -60 90")};
  with_labels.total_segmentator = true;
  const auto summary = prepare_case(ct_, case_, with_labels, kQuiet);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_THAT(summary->structure_names,
              testing::ElementsAre("liver", "pancreas", "liver 2", "pancreas 2"));
  const auto body = load_case(case_).value();
  ASSERT_EQ(body.structures.size(), 5U);
  EXPECT_EQ(body.structures[1].name, "liver");
  const auto liver = body.structures[1].mesh.bounds();
  EXPECT_NEAR(liver.min().x(), -22.0, 2.1);
  EXPECT_NEAR(liver.max().x(), -6.0, 2.1);

  with_labels.label_maps = {write_labels("other.mha", "4000 0 0")};
  const auto refused = prepare_case(ct_, place_ / "other", with_labels, kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("other.mha lies elsewhere in space than the CT"));
  EXPECT_FALSE(fs::exists(place_ / "other"));
}

TEST_F(PrepareTest, TakesSurfacesThatLieInTheBody) {
  const auto write_obj = [&](const std::string& name, double scale) {
    std::string text;
    for (const auto& v : {Eigen::Vector3d(0, -20, 130),
                          Eigen::Vector3d(9, -20, 130),
                          Eigen::Vector3d(0, -11, 130),
                          Eigen::Vector3d(0, -20, 139)})
      text += fmt::format("v {} {} {}\n", scale * v.x(), scale * v.y(), scale * v.z());
    EXPECT_TRUE(write_file(place_ / name, text + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"));
    return place_ / name;
  };
  auto with_mesh = options();
  with_mesh.meshes = {write_obj("bullet.obj", 1.0)};
  const auto summary = prepare_case(ct_, case_, with_mesh, kQuiet);
  ASSERT_TRUE(summary) << summary.error().message;
  const auto body = load_case(case_).value();
  ASSERT_EQ(body.structures.size(), 2U);
  EXPECT_EQ(body.structures[1].name, "bullet");
  EXPECT_NEAR(body.structures[1].mesh.bounds().max().z(), 139.0F, 1e-4F);

  with_mesh.meshes = {write_obj("metres.obj", 0.001)};
  const auto refused = prepare_case(ct_, place_ / "other", with_mesh, kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("metres.obj lies elsewhere in space than the CT"));
  EXPECT_THAT(refused.error().message, HasSubstr("or not in mm"));
}

TEST_F(PrepareTest, ReplacesACaseButNoOtherFolder) {
  fs::create_directories(case_ / "holiday pictures");
  const auto refused = prepare_case(ct_, case_, options(), kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("is no case"));
  EXPECT_TRUE(fs::exists(case_ / "holiday pictures"));

  fs::remove_all(case_);
  ASSERT_TRUE(prepare_case(ct_, case_, options(), kQuiet));
  auto more = options();
  more.skin.num_vertices = 1000;
  ASSERT_TRUE(prepare_case(ct_, case_, more, kQuiet));
  EXPECT_LT(load_case(case_)->skin->mesh.vertices.size(), 1100U);
}

TEST_F(PrepareTest, AKilledRunLeavesTheOldCaseAndTheNextCleansUp) {
  ASSERT_TRUE(prepare_case(ct_, case_, options(), kQuiet));
  const auto before = read_text_file(case_ / kCaseFile, 1U << 20U).value();
  const pid_t child = fork();
  if (child == 0) {
    auto fewer = options();
    fewer.skin.num_vertices = 500;
    // Dies with the files written and the folder not yet in its place.
    const auto die_late = [this](std::string_view stage, double) {
      if (stage != "write case") return;
      std::error_code status;
      if (fs::create_directories(case_.string() + ".part-1999999999", status)) {
        static_cast<void>(write_file(case_.string() + ".part-1999999999/skin.ply", "half"));
      }
      _exit(9);
    };
    static_cast<void>(prepare_case(ct_, case_, fewer, die_late));
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_EQ(WEXITSTATUS(status), 9);
  EXPECT_EQ(read_text_file(case_ / kCaseFile, 1U << 20U).value(), before);
  EXPECT_TRUE(load_case(case_));
  ASSERT_TRUE(prepare_case(ct_, case_, options(), kQuiet));
  for (const auto& entry : fs::directory_iterator(place_)) {
    EXPECT_EQ(entry.path().string().find(".part-"), std::string::npos) << entry.path();
  }
}

TEST_F(PrepareTest, LeavesNothingBehindWhenTheCtIsBad) {
  const auto refused = prepare_case(place_ / "missing.nii", case_, options(), kQuiet);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("missing.nii"));
  EXPECT_FALSE(fs::exists(case_));
}

}  // namespace
}  // namespace mor
