// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// Recordings that lie: one sentence each, never a crash, never more memory than the file is worth.

#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <unistd.h>

#include "morgagni/camera/internal/byte_io.h"
#include "morgagni/camera/internal/mcap/format.h"
#include "morgagni/camera/internal/mcap/reader.h"
#include "morgagni/camera/internal/mcap/topics.h"
#include "morgagni/camera/mcap_recording.h"
#include "morgagni/camera/testing/sample_recording.h"
#include "morgagni/core/files.h"

namespace mor {
namespace {

using internal::ByteWriter;
using internal::mcap::Opcode;
using testing::HasSubstr;
namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;

struct Record {
  Opcode opcode{};
  std::size_t at = 0;  ///< Of its content.
  std::size_t size = 0;
};

class HostileMcap : public testing::Test {
 protected:
  HostileMcap()
      : path_(fs::temp_directory_path() / ("mor_bad_" + std::to_string(getpid()) + ".mcap")) {
    fs::remove(path_);
    EXPECT_TRUE(internal::record_samples(path_, 40, {.color = ColorCoding::kLossless}));
    good_ = read_file(path_, 1U << 30U).value();
  }
  ~HostileMcap() override { fs::remove(path_); }

  /// What opening the file and reading every frame of it says.
  std::string error_of(const Bytes& bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    const auto recording = McapRecording::open(path_);
    if (!recording) return recording.error().message;
    std::string error = "read";
    for (std::size_t i = 0; i < recording->size(); ++i) {
      const auto frame = recording->read(i);
      const auto pose = recording->pose(i);
      if (!frame) error = frame.error().message;
      if (!pose) error = pose.error().message;
    }
    return error;
  }

  std::vector<Record> records() const {
    std::vector<Record> found;
    internal::ByteReader in(good_);
    (void)in.take_bytes(8);
    while (in.left() >= internal::mcap::kRecordHeadBytes) {
      const auto opcode = static_cast<Opcode>(in.take<std::uint8_t>());
      const auto size = in.take<std::uint64_t>();
      found.push_back({opcode, in.position(), size});
      (void)in.take_bytes(size);
    }
    return found;
  }
  Record first(Opcode opcode) const {
    for (const auto& record : records()) {
      if (record.opcode == opcode) return record;
    }
    ADD_FAILURE() << "no such record";
    return {};
  }
  template <class T>
  Bytes with(std::size_t at, T value) const {
    Bytes bytes = good_;
    std::memcpy(bytes.data() + at, &value, sizeof(value));
    return bytes;
  }

  fs::path path_;
  Bytes good_;
};

TEST_F(HostileMcap, IsNoRecordingAtAll) {
  const auto bytes_of = [](std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    return Bytes(bytes.begin(), bytes.end());
  };
  EXPECT_THAT(error_of({}), HasSubstr("is no MCAP recording"));
  EXPECT_THAT(error_of(bytes_of("PK\x03\x04 something else")), HasSubstr("is no MCAP recording"));
  EXPECT_THAT(error_of(Bytes(good_.begin(), good_.begin() + 8)), HasSubstr("no frames"));
  EXPECT_THAT(McapRecording::open("/dev/zero").error().message, HasSubstr("is no file"));
  EXPECT_THAT(McapRecording::open(fs::temp_directory_path()).error().message,
              HasSubstr("is no file"));
}

TEST_F(HostileMcap, ABadCheckSumIsNamed) {
  const auto chunk = first(Opcode::kChunk);
  EXPECT_THAT(error_of(with<std::uint8_t>(chunk.at + 24, 0x55)), HasSubstr("check sum is wrong"));
  const auto attachment = first(Opcode::kAttachment);
  EXPECT_THAT(error_of(with<char>(attachment.at + attachment.size - 30, '7')),
              HasSubstr("check sum of calibration.json is wrong"));
}

TEST_F(HostileMcap, LyingLengthsAreRefusedBeforeTheyAreBelieved) {
  const auto chunk = first(Opcode::kChunk);
  EXPECT_THAT(error_of(with(chunk.at + 16, std::uint64_t{1} << 60U)),
              HasSubstr("1152921504606846976 bytes, the limit is 268435456"));
  EXPECT_THAT(error_of(with(chunk.at + 16, std::uint64_t{100})),
              HasSubstr("the chunk's lengths do not agree"));
  EXPECT_THAT(error_of(with(chunk.at + 16 + 8 + 4 + 8, std::uint64_t{100})),
              HasSubstr("the chunk's lengths do not agree"));
  EXPECT_THAT(error_of(with(chunk.at + 16 + 8 + 4, std::uint32_t{0xFFFFFFFF})),
              HasSubstr("the chunk's lengths do not agree"));
  const auto index = first(Opcode::kMessageIndex);
  EXPECT_THAT(error_of(with(index.at + 2, std::uint32_t{0xFFFFFFF0})), HasSubstr("cut short"));
  // The first record that lies about its own length ends what can be read.
  EXPECT_THAT(error_of(with(chunk.at - 8, ~std::uint64_t{0})), HasSubstr("no frames"));
}

TEST_F(HostileMcap, AnIndexThatLeadsElsewhereIsFoundOut) {
  // The depth channel is the first, its first index entry: time, then offset.
  const auto index = first(Opcode::kMessageIndex);
  EXPECT_THAT(error_of(with(index.at + 6 + 8, std::uint64_t{3})), HasSubstr("does not lead"));
  EXPECT_THAT(error_of(with(index.at + 6 + 8, ~std::uint64_t{0})), HasSubstr("does not lead"));
}

/// A chunk of zeros that packs to almost nothing: a file of 20 kB, told to be 256 MiB and more.
TEST_F(HostileMcap, WhatUnpacksToTooMuchIsRefused) {
  const auto chunk = first(Opcode::kChunk);
  Bytes bytes = with(chunk.at + 16, std::uint64_t{256} << 20U);
  EXPECT_THAT(error_of(bytes), HasSubstr("the chunk's lengths do not agree"));
}

TEST_F(HostileMcap, AStrangersPackingAndMessagesAreNamed) {
  const auto chunk = first(Opcode::kChunk);
  EXPECT_THAT(error_of(with(chunk.at + 16 + 8 + 4 + 4, std::uint32_t{0x3434347A})),
              HasSubstr("packed with 'z444', Morgagni reads zstd only"));
  EXPECT_THAT(error_of(with(chunk.at - 9, static_cast<std::uint8_t>(Opcode::kMessage))),
              HasSubstr("outside of a chunk"));
}

TEST_F(HostileMcap, ACalibrationThatIsNoneIsNamed) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[]", "no JSON object"},
      {"{}", "has no depth"},
      {R"({"depth": {"width": 1e9}})", "depth.width must be a whole number in [1, 16384]"},
      {R"({"depth": {"width": 32, "height": 24, "fx": "x"}})", "depth.fx is no finite number"},
      {R"({"depth": {"width": 32, "height": 24, "fx": -1, "fy": 1, "cx": 1, "cy": 1,
          "distortion": [0,0,0,0,0]}})",
       "depth: "}};
  for (const auto& [json, sentence] : cases) {
    const auto at = first(Opcode::kAttachment);
    Bytes content(good_.begin() + static_cast<std::ptrdiff_t>(at.at),
                  good_.begin() + static_cast<std::ptrdiff_t>(at.at + 16));
    ByteWriter record;
    record.put(static_cast<std::uint8_t>(Opcode::kAttachment));
    const std::string name(internal::mcap::kCalibrationAttachment);
    record.put(static_cast<std::uint64_t>(16 + 4 + name.size() + 4 + 8 + json.size() + 4));
    record.put_bytes(content);
    record.put(static_cast<std::uint32_t>(name.size()));
    record.put_text(name);
    record.put(std::uint32_t{0});
    record.put(static_cast<std::uint64_t>(json.size()));
    record.put_text(json);
    record.put(std::uint32_t{0});  // No sum to check.
    Bytes bytes(good_.begin(), good_.begin() + static_cast<std::ptrdiff_t>(at.at - 9));
    bytes.insert(bytes.end(), record.bytes().begin(), record.bytes().end());
    bytes.insert(
        bytes.end(), good_.begin() + static_cast<std::ptrdiff_t>(at.at + at.size), good_.end());
    EXPECT_THAT(error_of(bytes), HasSubstr(sentence)) << json;
  }
}

TEST_F(HostileMcap, NoMutantDoesHarm) {
  std::mt19937 random(5);
  const auto heads = records();
  int num_refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Bytes bytes = good_;
    const int kind = i % 4;
    for (int k = 0; k < 1 + static_cast<int>(random() % 8); ++k) {
      // Anywhere; or in a record's head and first bytes, where the lengths stand.
      const auto& head = heads[random() % heads.size()];
      const auto at = kind == 0 ? random() % bytes.size() : head.at - 9 + random() % 48;
      bytes[at % bytes.size()] = static_cast<std::byte>(random());
    }
    if (kind == 2) bytes.resize(random() % bytes.size());
    if (kind == 3) {
      const auto& head = heads[random() % heads.size()];
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(head.at - 9);
      bytes.erase(begin, begin + static_cast<std::ptrdiff_t>(9 + head.size));
    }
    const auto error = error_of(bytes);
    ASSERT_FALSE(error.empty());
    num_refused += error == "read" ? 0 : 1;
  }
  EXPECT_GT(num_refused, 500);
}

}  // namespace
}  // namespace mor
