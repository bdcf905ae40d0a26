// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Findings from the tap on the live picture to the file in the case.
#include <chrono>
#include <cmath>
#include <map>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "morgagni/casefile/testing/synthetic_case.h"
#include "morgagni/core/image_png.h"
#include "morgagni/session/routes/findings_routes.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

std::shared_ptr<const Case> synthetic_case() {
  return testing_case::synthetic_case("findings_test");
}

class FindingsTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto body = synthetic_case();
    fs::remove_all(body->folder / "findings");
    auto camera = open_camera("simulated:",
                              std::shared_ptr<const TriangleMesh>(body->skin, &body->skin->mesh));
    ASSERT_TRUE(camera) << camera.error().message;
    LiveLoopOptions options;
    options.start = StartMethod::kPlacement;
    loop_ = LiveLoop::create(body, *std::move(camera), options).value();
    desk_ = std::make_shared<FindingsDesk>(body, loop_);
    loop_->mark([this](const ShownPicture& shown) { return desk_->marks(shown); });
    for (auto& route : make_findings_routes(desk_))
      routes_[route.method + " " + route.path] = route.handler;
    ASSERT_TRUE(loop_->run([](auto, const auto&) {}));
  }

  void TearDown() override { loop_->stop(); }

  /// Waits for the tracking and freezes a good picture.
  void freeze() {
    ASSERT_TRUE(eventually([this] {
      const auto snapshot = loop_->snapshot();
      return snapshot && snapshot->shown.tracked.state == TrackingState::kTracking &&
             snapshot->shown.bound_mm && !snapshot->shown.tracked.is_held;
    }));
    loop_->set_frozen(true);
    ASSERT_TRUE(eventually([this] { return loop_->snapshot()->shown.is_still; }));
  }

  static bool eventually(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < end) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  HttpResponse ask(const std::string& what,
                   const std::string& body = {},
                   std::map<std::string, std::string> query = {}) {
    return routes_.at(what)({what.substr(what.find(' ') + 1), std::move(query), body});
  }
  Json said(const std::string& what, const std::string& body = {}) {
    const auto response = ask(what, body);
    EXPECT_EQ(response.status, 200) << response.body;
    return Json::parse(response.body);
  }
  std::string refused(const std::string& what, const std::string& body) {
    const auto response = ask(what, body);
    EXPECT_EQ(response.status, 400) << response.body;
    return Json::parse(response.body)["error"];
  }
  Json tap(double x, double y) {
    return said("POST /api/findings/pick", Json{{"x", x}, {"y", y}}.dump());
  }
  std::string add(const std::string& kind,
                  const std::vector<Json>& picks,
                  const std::string& note) {
    Json request = {{"kind", kind}, {"picks", Json::array()}, {"note", note}};
    for (const auto& pick : picks) request["picks"].push_back(pick["pick"]);
    return request.dump();
  }
  static Eigen::Vector3d place_of(const Json& point) {
    return {point["ct_mm"][0].get<double>(),
            point["ct_mm"][1].get<double>(),
            point["ct_mm"][2].get<double>()};
  }

  std::shared_ptr<LiveLoop> loop_;
  std::shared_ptr<FindingsDesk> desk_;
  std::map<std::string, HttpHandler> routes_;
};

TEST_F(FindingsTest, TheFreeViewTakesNoFindings) {
  freeze();
  loop_->set_view([&] {
    auto view = loop_->view();
    view.free.is_shown = true;
    return view;
  }());
  ASSERT_TRUE(eventually([this] { return loop_->snapshot()->shown.is_free; }));
  EXPECT_EQ(refused("POST /api/findings/pick", R"({"x": 330, "y": 250})"),
            "findings are set on the camera's picture: switch back from the free view");
}

TEST_F(FindingsTest, ATapOnTheSkinIsAPlaceOnItThatIsMarkedWhereItWasTapped) {
  freeze();
  loop_->set_view([&] {
    auto view = loop_->view();
    view.hole.radius = 0.0F;
    return view;
  }());
  ASSERT_TRUE(eventually([this] { return loop_->snapshot()->shown.view.hole.radius == 0.0F; }));
  const Json pick = tap(330, 250);
  EXPECT_EQ(pick["on"], "skin");
  EXPECT_EQ(pick["on_skin"], true);
  EXPECT_GT(pick["bound_mm"].get<double>(), 0.05);
  EXPECT_LT(pick["bound_mm"].get<double>(), 20.0);
  const auto& mesh = synthetic_case()->skin->mesh;
  EXPECT_LT((nearest_on_surface(mesh, place_of(pick))->place_mm - place_of(pick)).norm(), 1e-3);

  const Json finding = said("POST /api/findings/add", add("point", {pick}, "bruise"));
  EXPECT_EQ(finding["id"], "F1");
  const auto marks = Json::parse(desk_->marks(loop_->snapshot()->shown));
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks[0]["id"], "F1");
  EXPECT_NEAR(marks[0]["points"][0][0].get<double>(), 330.0, 0.1);
  EXPECT_NEAR(marks[0]["points"][0][1].get<double>(), 250.0, 0.1);
  EXPECT_EQ(marks[0]["points"][0][2], 0) << "it faces the camera";
}

TEST_F(FindingsTest, ATapInTheHoleIsAPlaceOnTheBone) {
  freeze();
  const Json pick = tap(320, 240);
  EXPECT_EQ(pick["on"], "structure");
  EXPECT_EQ(pick["structure"], "bone");
  EXPECT_EQ(pick["on_skin"], false);
}

TEST_F(FindingsTest, MeasuresStraightAndOverTheSkin) {
  freeze();
  auto view = loop_->view();
  view.hole.radius = 0.0F;
  loop_->set_view(view);
  ASSERT_TRUE(eventually([this] { return loop_->snapshot()->shown.view.hole.radius == 0.0F; }));
  const Json a = tap(300, 230);
  const Json b = tap(350, 270);
  const Json straight = said("POST /api/findings/add", add("distance", {a, b}, ""));
  const double length_mm = (place_of(a) - place_of(b)).norm();
  EXPECT_NEAR(straight["length_mm"].get<double>(), length_mm, 1e-9);
  EXPECT_NEAR(straight["length_bound_mm"].get<double>(),
              std::hypot(a["bound_mm"].get<double>(), b["bound_mm"].get<double>()),
              1e-9);
  const Json c = tap(300, 230);
  const Json d = tap(350, 270);
  const Json over = said("POST /api/findings/add", add("geodesic", {c, d}, ""));
  EXPECT_GE(over["length_mm"].get<double>(), length_mm - 1e-6);
  EXPECT_LT(over["length_mm"].get<double>(), 1.6 * length_mm);
  const auto kept = desk_->findings().value();
  EXPECT_GT(kept[1].path_ct_mm.size(), 2U);
  EXPECT_LT((kept[1].path_ct_mm.front() - place_of(c)).norm(), 0.01);
}

TEST_F(FindingsTest, AWayOverTheSkinNeedsTwoPointsOnIt) {
  freeze();
  const Json inside = tap(320, 240);
  const Json inside_too = tap(330, 240);
  EXPECT_THAT(refused("POST /api/findings/add", add("geodesic", {inside, inside_too}, "")),
              HasSubstr("two points on the skin"));
}

TEST_F(FindingsTest, KeepsPhotosOfThePlace) {
  freeze();
  const Json pick = tap(320, 240);
  said("POST /api/findings/add", add("point", {pick}, ""));
  for (const bool overlay : {false, true}) {
    std::map<std::string, std::string> query = {{"id", "F1"}};
    if (overlay) query["overlay"] = "1";
    const auto response = ask("GET /api/findings/photo.png", "", query);
    ASSERT_EQ(response.status, 200) << response.body;
    EXPECT_TRUE(response.body.starts_with("\x89PNG"));
  }
  const auto photo = read_png_rgb(synthetic_case()->folder / "findings" / "F1.png");
  ASSERT_TRUE(photo);
  EXPECT_GT(photo->width(), 40);
  EXPECT_LT(photo->width(), 640);
  const auto shown = loop_->snapshot()->shown.tracked.frame;
  EXPECT_EQ((*photo)(photo->width() / 2, photo->height() / 2), shown->color(320, 240))
      << "the tapped pixel in the middle, as the camera gave it";
  EXPECT_EQ(ask("GET /api/findings/photo.png", "", {{"id", "../../case.json"}}).status, 400);
}

TEST_F(FindingsTest, AreThereAgainWithTheCase) {
  freeze();
  const std::string note = "<script>alert(1)</script> \"x\" & Größe\n2nd line";
  said("POST /api/findings/add", add("point", {tap(320, 240)}, note));
  said("POST /api/findings/add", add("point", {tap(320, 240)}, "second"));
  said("POST /api/findings/note", R"({"id": "F2", "note": "changed"})");
  Json list = said("POST /api/findings/delete", R"({"id": "F1"})");
  EXPECT_EQ(list["findings"].size(), 1U);
  EXPECT_EQ(list["undoable"], "the deletion of F1");
  list = said("POST /api/findings/undo");
  EXPECT_EQ(list["findings"][0]["note"], note);
  const FindingsDesk again(synthetic_case(), loop_);
  const auto kept = again.findings().value();
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].note, note);
  EXPECT_EQ(kept[1].note, "changed");
  EXPECT_TRUE(kept[1].points[0].bound_mm);
}

TEST_F(FindingsTest, RefusesHostileRequestsWithASentence) {
  freeze();
  const auto pick = "POST /api/findings/pick";
  EXPECT_THAT(refused(pick, R"({"x": "1", "y": 2})"), HasSubstr("x must be a number"));
  EXPECT_THAT(refused(pick, R"({"x": 1e308, "y": 2})"), HasSubstr("no body at this point"));
  EXPECT_THAT(refused(pick, R"({"x": 1, "y": 2})"), HasSubstr("no body at this point"));
  EXPECT_THAT(refused(pick, R"({"x": 320, "y": 240, "frame_id": 99999999})"), HasSubstr("gone"));
  EXPECT_THAT(refused(pick, R"({"x": 320, "y": 240, "frame_id": -1})"), HasSubstr("frame_id"));
  EXPECT_THAT(refused(pick, "\xff"), HasSubstr("JSON"));
  const auto add_path = "POST /api/findings/add";
  EXPECT_THAT(refused(add_path, R"({"kind": "point", "picks": [77]})"), HasSubstr("tap it again"));
  EXPECT_THAT(refused(add_path, R"({"kind": "line", "picks": [1]})"), HasSubstr("kind must be"));
  EXPECT_THAT(refused(add_path, R"({"kind": "point", "picks": [1, 2, 3]})"), HasSubstr("picks"));
  EXPECT_THAT(refused(add_path, add("distance", {tap(320, 240)}, "")), HasSubstr("2 point(s)"));
  EXPECT_THAT(refused(add_path, add("point", {tap(320, 240)}, std::string(4001, 'x'))),
              HasSubstr("4000"));
  EXPECT_THAT(refused(add_path, add("point", {tap(320, 240)}, "\x1b[2J")), HasSubstr("control"));
  EXPECT_THAT(refused("POST /api/findings/delete", R"({"id": "F1"})"), HasSubstr("no finding F1"));
  EXPECT_TRUE(desk_->findings()->empty());
}

TEST_F(FindingsTest, SaysWhyADamagedListIsNotShown) {
  fs::create_directories(synthetic_case()->folder / "findings");
  ASSERT_TRUE(write_file(synthetic_case()->folder / "findings" / "findings.json", "{"));
  const FindingsDesk damaged(synthetic_case(), loop_);
  ASSERT_FALSE(damaged.findings());
  EXPECT_THAT(damaged.findings().error().message, HasSubstr("damaged"));
}

/// A picture from the front, 500 mm before the body's middle.
ShownPicture from_front() {
  ShownPicture shown;
  shown.camera = {640, 480, 525.0, 525.0, 319.5, 239.5, {}};
  Eigen::Isometry3d camera_from_ct = Eigen::Isometry3d::Identity();
  // x to the left of the body, z of the camera to its back, y to its feet.
  camera_from_ct.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Eigen::Vector3d middle = synthetic_case()->skin->mesh.bounds().center().cast<double>();
  camera_from_ct.translation() = Eigen::Vector3d(0, 0, 500) - camera_from_ct.linear() * middle;
  shown.camera_from_ct = camera_from_ct;
  return shown;
}

TEST(FindingMarks, DimWhatTheBodyHides) {
  const auto body = synthetic_case();
  FindingMarks marks(std::shared_ptr<const TriangleMesh>(body->skin, &body->skin->mesh));
  const Eigen::Vector3d middle = body->skin->mesh.bounds().center().cast<double>();
  const auto on_skin = [&](double y) {
    const auto place = nearest_on_surface(body->skin->mesh, middle + Eigen::Vector3d(0, y, 0));
    return FindingPoint{.ct_mm = place->place_mm, .is_on_skin = true, .bound_mm = 1.0};
  };
  Finding front;
  front.id = "F1";
  front.points = {on_skin(-200)};
  Finding back = front;
  back.id = "F2";
  back.points = {on_skin(200)};
  Finding inside = front;
  inside.id = "F3";
  inside.points = {{.ct_mm = middle, .is_on_skin = false, .bound_mm = {}}};
  marks.set({front, back, inside}, {});
  auto shown = from_front();
  shown.view.hole = {.center = {0.5F, 0.5F}, .radius = 0.3F};
  std::map<std::string, int> dim;
  const auto list = Json::parse(marks.json(shown));
  for (const auto& mark : list) dim[mark["id"]] = mark["points"][0][2];
  EXPECT_EQ(dim, (std::map<std::string, int>{{"F1", 0}, {"F2", 1}, {"F3", 0}}));
  shown.view.hole.radius = 0.0F;
  for (const auto& mark : Json::parse(marks.json(shown))) dim[mark["id"]] = mark["points"][0][2];
  EXPECT_EQ(dim["F3"], 1) << "the hole is closed";
  shown.camera_from_ct.reset();
  EXPECT_EQ(marks.json(shown), "") << "no pose, no marks";
}

TEST(FindingMarks, CarryNoMoreThanAPictureCan) {
  const auto body = synthetic_case();
  FindingMarks marks(std::shared_ptr<const TriangleMesh>(body->skin, &body->skin->mesh));
  Finding finding;
  finding.points = {{.ct_mm = body->skin->mesh.bounds().center().cast<double>(),
                     .is_on_skin = false,
                     .bound_mm = {}}};
  std::vector<Finding> many(2000, finding);
  for (std::size_t i = 0; i < many.size(); ++i) many[i].id = "F" + std::to_string(i + 1);
  marks.set(many, {});
  const auto list = Json::parse(marks.json(from_front()));
  ASSERT_EQ(list.size(), FindingMarks::kMaxMarks);
  EXPECT_EQ(list[0]["id"], "F2000") << "the newest first";
}

TEST(FindingMarks, SayLengthsWithTheirBound) {
  EXPECT_EQ(length_label(123.44, 2.06), "123.4 mm ± 2.1 mm");
  EXPECT_EQ(length_label(7.0, std::nullopt), "7.0 mm");
}

}  // namespace
}  // namespace mor
