// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/stream/live_server.h"

#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "morgagni/stream/testing/browser_offer.h"
#include "morgagni/stream/testing/http_client.h"
#include "morgagni/stream/testing/test_pattern.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::browser_offer;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RawClient;
using testing::request;
using namespace std::chrono_literals;

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

/// A page of a few files, with a secret beside it that must never be served.
class LiveServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("morgagni_page_" + std::to_string(::getpid()));
    fs::create_directories(web_root() / "assets");
    write(folder_ / "secret.txt", "do not tell");
    write(web_root() / "index.html", "<p>the page</p>");
    write(web_root() / "assets" / "main-1a2b.js", "run()");
    write(web_root() / ".hidden", "do not tell");
    fs::create_symlink(folder_ / "secret.txt", web_root() / "link.txt");
  }
  void TearDown() override {
    server_.reset();
    fs::remove_all(folder_);
  }

  [[nodiscard]] fs::path web_root() const { return folder_ / "dist"; }

  void start(std::vector<HttpRoute> routes = {}, int max_viewers = 8) {
    auto server = LiveServer::start({.port = 0, .web_root = web_root(), .max_viewers = max_viewers},
                                    std::move(routes));
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
  }

  [[nodiscard]] std::uint16_t port() const { return server_->port(); }

  /// The path of a viewer that was let in.
  [[nodiscard]] std::string join() const {
    const auto response = request(port(), "POST", "/whep", browser_offer());
    const auto location = response.head.find("Location: ");
    if (response.status != 201 || location == std::string::npos) return {};
    return response.head.substr(location + 10,
                                response.head.find("\r\n", location) - location - 10);
  }

  fs::path folder_;
  std::unique_ptr<LiveServer> server_;
};

TEST(LiveServerOptionsCheck, RefusesValuesOutsideOfTheirRange) {
  EXPECT_THAT(LiveServer::start({.web_root = {}, .bitrate_kbps = 99}, {}).error().message,
              "bitrate_kbps must be in 100..50000, got 99");
  EXPECT_THAT(LiveServer::start({.web_root = {}, .max_viewers = 0}, {}).error().message,
              "max_viewers must be in 1..64, got 0");
}

TEST(LiveServerOptionsCheck, SaysHowToBuildThePageWhereItIsMissing) {
  const auto server = LiveServer::start({.port = 0, .web_root = "/nowhere/dist"}, {});
  ASSERT_FALSE(server);
  EXPECT_EQ(server.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(server.error().message, "the page is not built: run ./run --build");
}

TEST_F(LiveServerTest, NamesThePortThatIsInUseAndWhatToDo) {
  start();
  const auto second = LiveServer::start({.port = port(), .web_root = web_root()}, {});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kDevice);
  EXPECT_EQ(second.error().message,
            "port " + std::to_string(port()) + " is in use: choose another with --port");
}

TEST_F(LiveServerTest, ServesThePageWithItsTypes) {
  start();
  const auto index = request(port(), "GET", "/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.body, "<p>the page</p>");
  EXPECT_THAT(index.head, HasSubstr("Content-Type: text/html; charset=utf-8"));
  EXPECT_THAT(index.head, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(index.head, HasSubstr("Content-Security-Policy: default-src 'self'"));
  const auto script = request(port(), "GET", "/assets/main-1a2b.js");
  EXPECT_THAT(script.head, HasSubstr("Content-Type: text/javascript; charset=utf-8"));
  EXPECT_THAT(script.head, HasSubstr("immutable"));
  EXPECT_EQ(request(port(), "HEAD", "/").body, "");
}

TEST_F(LiveServerTest, NeverLeavesThePagesFolder) {
  start();
  for (const auto* path : {"/../secret.txt",
                           "/%2e%2e/secret.txt",
                           "/..%2fsecret.txt",
                           "/assets/../../secret.txt",
                           "//secret.txt",
                           "/assets/..%5c..%5csecret.txt",
                           "/.hidden",
                           "/link.txt",
                           "/%00",
                           "/assets",
                           "/index.html%00.png"}) {
    const auto response = request(port(), "GET", path);
    EXPECT_THAT(response.status, ::testing::AnyOf(400, 404)) << path;
    EXPECT_THAT(response.body, Not(HasSubstr("do not tell"))) << path;
    EXPECT_THAT(response.body, HasSubstr("\"error\":")) << path;
  }
}

TEST_F(LiveServerTest, CallsTheRouteWithPathQueryAndBody) {
  start({{"POST", "/api/echo", [](const HttpRequest& got) {
            return HttpResponse{.status = 202,
                                .content_type = "text/plain",
                                .body = got.path + "|" + got.query.at("a") + "|" + got.body};
          }}});
  const auto response = request(port(), "POST", "/api/echo?a=1%202&b", "hello");
  EXPECT_EQ(response.status, 202);
  EXPECT_EQ(response.body, "/api/echo|1 2|hello");
}

TEST_F(LiveServerTest, AnswersWrongRequestsInSentences) {
  start({{"GET", "/api/case", [](const HttpRequest&) { return HttpResponse{.body = "{}"}; }},
         {"POST", "/api/broken", [](const HttpRequest&) -> HttpResponse {
            throw std::runtime_error("unforeseen");
          }}});
  const auto missing = request(port(), "GET", "/api/nothing");
  EXPECT_EQ(missing.status, 404);
  EXPECT_EQ(missing.body, R"({"error":"there is nothing at /api/nothing"})");
  const auto wrong_method = request(port(), "DELETE", "/api/case");
  EXPECT_EQ(wrong_method.status, 405);
  EXPECT_THAT(wrong_method.head, HasSubstr("Allow: GET"));
  EXPECT_THAT(wrong_method.body, HasSubstr("/api/case does not take DELETE, it takes GET"));
  EXPECT_EQ(request(port(), "POST", "/").status, 405);
  EXPECT_EQ(request(port(), "POST", "/api/events").status, 405);
  const auto broken = request(port(), "POST", "/api/broken", "{}");
  EXPECT_EQ(broken.status, 500);
  EXPECT_THAT(broken.body, Not(HasSubstr("unforeseen")));
}

TEST_F(LiveServerTest, RefusesBodiesWithoutEnd) {
  start({{"POST", "/api/take", [](const HttpRequest&) { return HttpResponse{.body = "{}"}; }}});
  EXPECT_EQ(request(port(), "POST", "/api/take", std::string(1024 * 1024, 'x')).status, 200);
  const auto large = request(port(), "POST", "/api/take", std::string(1024 * 1024 + 1, 'x'));
  EXPECT_EQ(large.status, 413);
  EXPECT_THAT(large.body, HasSubstr("at most 1 MiB"));
  const RawClient chunked(port());
  chunked.send(
      "POST /api/take HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
      "5\r\nhello\r\n0\r\n\r\n");
  EXPECT_THAT(chunked.read_until("}", 2s), HasSubstr("411"));
}

TEST_F(LiveServerTest, IsNoServantOfOtherSites) {
  start();
  EXPECT_EQ(request(port(), "GET", "/", "", "Host: evil.example\r\n").status, 403);
  EXPECT_EQ(request(port(),
                    "POST",
                    "/whep",
                    browser_offer(),
                    "Host: 127.0.0.1\r\nOrigin: https://evil.example\r\n")
                .status,
            403);
  EXPECT_EQ(request(port(), "GET", "/", "", "Host: localhost:1234\r\n").status, 200);
}

TEST_F(LiveServerTest, SurvivesBytesThatAreNotHttp) {
  start();
  std::mt19937 random(7);
  for (int i = 0; i < 50; ++i) {
    std::string bytes(1 + random() % 2000, ' ');
    for (char& byte : bytes) byte = static_cast<char>(random());
    const RawClient client(port());
    client.send(i % 2 == 0 ? bytes : "GET /" + bytes + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  EXPECT_EQ(request(port(), "GET", "/").status, 200);
}

TEST_F(LiveServerTest, SendsEachStatusAsAnEvent) {
  start();
  server_->publish_status(R"({"state":"waiting"})");
  const RawClient client(port());
  client.send("GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  // The last status comes at once, a new one when it is published, on one line each.
  const auto head = client.read_until("waiting\"}\n\n", 5s);
  EXPECT_THAT(head, HasSubstr("Content-Type: text/event-stream"));
  EXPECT_THAT(head, HasSubstr("event: status\ndata: {\"state\":\"waiting\"}\n\n"));
  server_->publish_status("{\"state\":\n\"tracking\"}");
  EXPECT_THAT(client.read_until("tracking\"}\n\n", 5s),
              HasSubstr("event: status\ndata: {\"state\": \"tracking\"}\n\n"));
  EXPECT_THAT(client.read_until(":\n\n", 5s), HasSubstr(":\n\n")) << "no heartbeat";
}

TEST_F(LiveServerTest, GivesASlowListenerTheNewestStatusOnly) {
  start();
  const RawClient client(port());
  client.send("GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_THAT(client.read_until("\n\n", 5s), HasSubstr("200"));
  const std::string padding(200'000, 'x');
  for (int i = 0; i < 200; ++i)
    server_->publish_status("{\"n\":" + std::to_string(i) + ",\"p\":\"" + padding + "\"}");
  // 40 MB were published while nobody read: only what fits a socket, and then the last, arrives.
  const auto all = client.read_until("{\"n\":199,", 10s);
  EXPECT_THAT(all, HasSubstr("{\"n\":199,"));
  EXPECT_LT(all.size(), 30'000'000U);
  EXPECT_EQ(request(port(), "GET", "/").status, 200);
}

TEST_F(LiveServerTest, AnswersABrowsersOfferOnLoopbackOnly) {
  start();
  const auto response = request(port(), "POST", "/whep", browser_offer(120));
  ASSERT_EQ(response.status, 201) << response.body;
  EXPECT_THAT(response.head, HasSubstr("Content-Type: application/sdp"));
  EXPECT_THAT(response.head, HasSubstr("Location: /whep/"));
  EXPECT_THAT(response.body, HasSubstr("a=rtpmap:120 VP8/90000"));
  EXPECT_THAT(response.body, HasSubstr("a=sendonly"));
  std::istringstream lines(response.body);
  int num_candidates = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("a=candidate:")) continue;
    ++num_candidates;
    EXPECT_THAT(line, HasSubstr(" 127.0.0.1 "));
  }
  EXPECT_GT(num_candidates, 0);
  EXPECT_EQ(server_->stats().num_viewers, 1);
}

TEST_F(LiveServerTest, RefusesOffersItCannotServe) {
  start();
  std::string without_vp8 = browser_offer();
  without_vp8.replace(without_vp8.find("VP8"), 3, "AV1");
  const std::string offer = browser_offer();
  const std::string no_secret = [&] {
    std::string text = offer;
    for (auto at = text.find("a=ice-pwd"); at != text.npos; at = text.find("a=ice-pwd")) {
      text.erase(at, text.find("\r\n", at) + 2 - at);
    }
    return text;
  }();
  const std::string without_media = offer.substr(0, offer.find("m=video"));
  const std::string with_audio = offer + "m=audio 9 UDP/TLS/RTP/SAVPF 111\r\na=mid:2\r\n";
  for (const std::string& bad : {std::string("nonsense"),
                                 std::string(),
                                 std::string("v=0\r\n\0", 6),
                                 without_vp8,
                                 without_media,
                                 with_audio,
                                 no_secret,
                                 offer + std::string(70'000, 'a')}) {
    const auto response = request(port(), "POST", "/whep", bad);
    EXPECT_EQ(response.status, 400) << bad.substr(0, 200);
    EXPECT_THAT(response.body, HasSubstr("\"error\":\"the offer "));
  }
  std::this_thread::sleep_for(1200ms);
  EXPECT_EQ(server_->stats().num_viewers, 0) << "a refused viewer keeps its place";
}

TEST_F(LiveServerTest, SurvivesMutatedOffers) {
  start({}, 64);
  std::mt19937 random(11);
  for (int i = 0; i < 60; ++i) {
    std::string offer = browser_offer();
    const auto at = random() % offer.size();
    if (i % 3 == 0) offer.erase(at, 1 + random() % 40);
    if (i % 3 == 1) offer[at] = static_cast<char>(random());
    if (i % 3 == 2) offer.insert(at, offer.substr(random() % offer.size(), random() % 80));
    const auto response = request(port(), "POST", "/whep", offer);
    EXPECT_THAT(response.status, ::testing::AnyOf(201, 400, 503)) << response.body;
  }
  EXPECT_EQ(request(port(), "GET", "/").status, 200);
}

TEST_F(LiveServerTest, HasAPlaceAgainWhenAViewerHangsUp) {
  start({}, 1);
  const std::string viewer = join();
  ASSERT_THAT(viewer, ::testing::StartsWith("/whep/"));
  const auto full = request(port(), "POST", "/whep", browser_offer());
  EXPECT_EQ(full.status, 503);
  EXPECT_THAT(full.body, HasSubstr("all places for viewers are taken"));
  EXPECT_EQ(request(port(), "GET", viewer).status, 405);
  EXPECT_EQ(request(port(), "DELETE", viewer).status, 200);
  EXPECT_EQ(request(port(), "DELETE", viewer).status, 404);
  EXPECT_EQ(request(port(), "DELETE", "/whep/unknown").status, 404);
  EXPECT_NE(join(), "");
}

std::size_t count_entries(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_F(LiveServerTest, LeavesNothingBehindOf200Viewers) {
  start();
  const auto come_and_go = [&](int times) {
    for (int i = 0; i < times; ++i) {
      const std::string viewer = join();
      ASSERT_NE(viewer, "") << i;
      ASSERT_EQ(request(port(), "DELETE", viewer).status, 200);
    }
  };
  // The first ones fill pools that stay.
  come_and_go(20);
  const auto threads = count_entries("/proc/self/task");
  const auto files = count_entries("/proc/self/fd");
  come_and_go(180);
  EXPECT_LE(count_entries("/proc/self/task"), threads + 4);
  EXPECT_LE(count_entries("/proc/self/fd"), files + 8);
  EXPECT_EQ(server_->stats().num_viewers, 0);
}

TEST_F(LiveServerTest, EncodesEveryPictureThatComesInTime) {
  start();
  testing::TestPattern pattern(640, 480);
  for (std::uint32_t i = 0; i < 20; ++i) {
    server_->show(pattern.draw(i), {std::chrono::steady_clock::now() - 10ms, "{}"});
    std::this_thread::sleep_for(60ms);
  }
  const auto stats = server_->stats();
  EXPECT_EQ(stats.num_encoded + stats.num_dropped, 20U);
  EXPECT_GE(stats.num_encoded, 15U);
  EXPECT_GT(stats.encode_ms, 0.0);
  EXPECT_GE(stats.capture_to_encoded_ms, 10.0 + stats.encode_ms * 0.5);
  EXPECT_GE(stats.capture_to_encoded_p95_ms, stats.capture_to_encoded_ms);
}

TEST_F(LiveServerTest, DropsOlderPicturesInsteadOfQueueingThem) {
  start();
  testing::TestPattern pattern(1280, 720);
  const auto picture = pattern.draw(1);
  for (int i = 0; i < 60; ++i) server_->show(picture, {std::chrono::steady_clock::now(), "{}"});
  std::this_thread::sleep_for(400ms);
  const auto stats = server_->stats();
  EXPECT_EQ(stats.num_encoded + stats.num_dropped, 60U);
  EXPECT_GT(stats.num_dropped, 5U);
}

TEST_F(LiveServerTest, TakesOddAndChangingSizesAndRefusesImpossibleOnes) {
  start();
  for (const auto& [width, height] :
       {std::pair{641, 479}, {640, 480}, {1280, 720}, {385, 33}, {641, 479}}) {
    testing::TestPattern pattern(width, height);
    server_->show(pattern.draw(5), {std::chrono::steady_clock::now(), "{}"});
    std::this_thread::sleep_for(150ms);
  }
  server_->show(ImageView<const Rgba8>(), {std::chrono::steady_clock::now(), "{}"});
  const Image<Rgba8> tiny(8, 8);
  server_->show(tiny.view(), {std::chrono::steady_clock::now(), "{}"});
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(server_->stats().num_encoded, 5U);
}

TEST_F(LiveServerTest, EndsAtOnceWhileViewersAndListenersAreThere) {
  start();
  ASSERT_NE(join(), "");
  const RawClient listener(port());
  listener.send("GET /api/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  ASSERT_THAT(listener.read_until("\n\n", 5s), HasSubstr("200"));
  testing::TestPattern pattern(640, 480);
  server_->show(pattern.draw(1), {std::chrono::steady_clock::now(), "{}"});
  const auto begin = std::chrono::steady_clock::now();
  server_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
}

}  // namespace
}  // namespace mor
