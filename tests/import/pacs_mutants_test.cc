// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// 2,000 mutants of each thing that a PACS says, or the process that talks to one tells its parent:
// each is taken apart within its limits or refused with one clear sentence.
#include <random>
#include <string>

#include <gmock/gmock.h>

#include "morgagni/ct/testing/sample_files.h"
#include "morgagni/pacs/internal/dicom_json.h"
#include "morgagni/pacs/internal/dimse_talk.h"
#include "morgagni/pacs/internal/multipart_reader.h"
#include "morgagni/pacs/internal/part10.h"

#include "mutation.h"

namespace mor {
namespace {

using namespace mor::internal;

constexpr int kNumMutants = 2000;

/// Counts how many of the mutants are taken; `take` says so of each.
template <class Take>
int num_taken(const std::string& whole, const Take& take) {
  std::mt19937 random(20261126);
  int taken = 0;
  for (int i = 0; i < kNumMutants && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE("mutant " + std::to_string(i));
    if (take(mutated(whole, random), random)) ++taken;
  }
  return taken;
}

void expect_clear(const Error& error) {
  EXPECT_FALSE(error.message.empty());
  EXPECT_LT(error.message.size(), 500U);
  EXPECT_EQ(error.message.find_first_of("\n\r"), std::string::npos) << error.message;
}

/// Feeds a text in pieces of random sizes until it is refused.
template <class Feed>
void feed_in_pieces(std::string_view text, std::mt19937& random, const Feed& feed) {
  while (!text.empty()) {
    const auto num = std::uniform_int_distribution<std::size_t>(1, 200)(random);
    if (!feed(text.substr(0, num))) return;
    text.remove_prefix(std::min(num, text.size()));
  }
}

TEST(PacsMutants, OfMultipartGoInPartsThatBeginAndEnd) {
  const std::string slice = testing_files::sample_files("dicom").front().bytes;
  const std::string part = "--b\r\nContent-Type: application/dicom\r\n\r\n" + slice + "\r\n";
  const int taken = num_taken(part + part + "--b--\r\n", [](const std::string& body, auto& random) {
    bool is_open = false;
    std::size_t num_bytes = 0;
    std::string head;
    MultipartReader reader("b",
                           {.begin = [&]() -> Result<void> {
                              EXPECT_FALSE(std::exchange(is_open, true));
                              head.clear();
                              return {};
                            },
                            .data = [&](std::string_view bytes) -> Result<void> {
                              EXPECT_TRUE(is_open);
                              num_bytes += bytes.size();
                              head += bytes;
                              return {};
                            },
                            .end = [&]() -> Result<void> {
                              EXPECT_TRUE(std::exchange(is_open, false));
                              const auto uid = part10_uid(head);
                              if (!uid) expect_clear(uid.error());
                              if (uid) EXPECT_TRUE(is_dicom_uid(*uid)) << *uid;
                              return {};
                            }});
    Result<void> fed;
    feed_in_pieces(body, random, [&](std::string_view bytes) {
      fed = reader.feed(bytes);
      return fed.has_value();
    });
    EXPECT_LE(num_bytes, body.size());
    const Result<void> ended = fed ? reader.finish() : fed;
    if (!ended) expect_clear(ended.error());
    if (ended) EXPECT_FALSE(is_open) << "a part has no end";
    return ended.has_value();
  });
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, kNumMutants);
}

TEST(PacsMutants, OfDicomJsonAreListsOfBoundedTexts) {
  const int taken = num_taken(
      R"([{"0020000D":{"vr":"UI","Value":["1.2.3"]},"00100010":{"vr":"PN","Value":[{"Alphabetic":)"
      R"("A^B"}]},"00201209":{"vr":"IS","Value":[138]},"00080061":{"vr":"CS","Value":["CT","SEG",)"
      R"(1.5,null]}},{"00081030":{"vr":"LO"}}])",
      [](const std::string& text, auto&) {
        const auto objects = parse_dicom_json(text);
        if (!objects) expect_clear(objects.error());
        if (!objects) return false;
        for (const auto& values : *objects) {
          for (const auto& [name, value] : values) {
            EXPECT_EQ(name.size(), 8U);
            EXPECT_LE(value.size(), 1024U);
          }
          const auto series = series_of(values, "1.2");
          EXPECT_GE(series.num_instances, 0);
          EXPECT_LE(series.num_instances, kMaxInstances);
        }
        return true;
      });
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, kNumMutants);
}

TEST(PacsMutants, OfTheChildsTalkEndItOrAreEvents) {
  const int taken = num_taken(
      "{\"match\":{\"0020000D\":\"1.2.3\",\"00080061\":\"CT\\\\MR\"}}\n"
      "{\"stored\":{\"file\":\"a.dcm\",\"bytes\":5,\"tags\":{\"00080018\":\"1.2\"}}}\n"
      "{\"caller\":\"MODALITY\"}\n{\"refused\":\"too large\"}\n{\"failed\":\"no "
      "route\",\"code\":2}\n"
      "{\"done\":3}\n",
      [](const std::string& text, auto& random) {
        int num_events = 0;
        const auto heard = [&](const std::string& word) {
          ++num_events;
          EXPECT_LE(word.size(), 600U) << "200 bytes, three for each that is none";
        };
        const DimseEvents events = {
            .match = [&](TagValues) { ++num_events; },
            .stored = [&](const std::filesystem::path&, TagValues) { ++num_events; },
            .caller = heard,
            .refused = heard};
        DimseTalk talk(events);
        feed_in_pieces(text, random, [&](std::string_view bytes) {
          talk.hear(bytes);
          return !talk.is_broken();
        });
        EXPECT_LE(num_events, std::count(text.begin(), text.end(), '\n'));
        if (talk.outcome() && !*talk.outcome()) expect_clear(talk.outcome()->error());
        if (talk.is_broken()) {
          talk.hear("{\"caller\":\"again\"}\n");
          EXPECT_TRUE(talk.is_broken());
        }
        return !talk.is_broken() && talk.outcome().has_value();
      });
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, kNumMutants);
}

}  // namespace
}  // namespace mor
