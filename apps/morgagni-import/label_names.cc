// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "label_names.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include <zlib.h>

#include "messages.h"

namespace mor::import {
namespace {

constexpr std::size_t kMaxHeadBytes = 1U << 20U;
constexpr std::size_t kMaxNames = 1000;

/// The file's first bytes, inflated where they are compressed.
std::string head_of(const std::filesystem::path& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(::gzopen(path.c_str(), "rb"), ::gzclose);
  std::string head;
  std::array<char, 8192> piece{};
  while (file && head.size() < kMaxHeadBytes) {
    const int got = ::gzread(file.get(), piece.data(), static_cast<unsigned>(piece.size()));
    if (got <= 0) break;
    head.append(piece.data(), static_cast<std::size_t>(got));
  }
  return head;
}

struct Segment {
  int value = 0;
  std::string name;
  std::array<double, 3> color = {1.0, 1.0, 1.0};
};

/// 0, which names nothing, where it is no label.
int label_of(double number) {
  constexpr double kMost = 32767.0;
  return number >= 0.0 && number <= kMost ? static_cast<int>(number) : 0;
}

void say(const Segment& segment) {
  if (segment.value > 0 && !segment.name.empty())
    say_label(segment.value, segment.color, segment.name);
}

/// "Segment12_Color:=0.5 0.2 0.1" and its like, up to the empty line that ends the head.
void say_slicer_names(const std::string& head) {
  std::map<long, Segment> segments;
  for (std::size_t start = 0; start < head.size();) {
    const auto end = std::min(head.find('\n', start), head.size());
    std::string line = head.substr(start, end - start);
    start = end + 1;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) break;
    constexpr std::string_view kKey = "Segment";
    const auto underscore = line.find('_');
    const auto colon = line.find(":=");
    if (!line.starts_with(kKey) || underscore == std::string::npos || colon == std::string::npos ||
        colon < underscore || segments.size() >= kMaxNames)
      continue;
    Segment& segment = segments[std::strtol(line.c_str() + kKey.size(), nullptr, 10)];
    const std::string key = line.substr(underscore + 1, colon - underscore - 1);
    const std::string value = line.substr(colon + 2);
    if (key == "Name") segment.name = value;
    if (key == "LabelValue") segment.value = label_of(std::strtod(value.c_str(), nullptr));
    if (key == "Color") {
      char* next = const_cast<char*>(value.c_str());
      for (auto& channel : segment.color) channel = std::strtod(next, &next);
    }
  }
  for (const auto& [number, segment] : segments) say(segment);
}

/// `Red="0.5"` within a tag; 0 where it is not there.
double attribute(std::string_view tag, std::string_view name) {
  const auto at = tag.find(std::string(name) + "=\"");
  if (at == std::string_view::npos) return 0.0;
  return std::strtod(std::string(tag.substr(at + name.size() + 2, 24)).c_str(), nullptr);
}

/// <Label Key="5" Red="0.5" Green="0.2" Blue="0.1" Alpha="1"><![CDATA[liver]]></Label>
void say_table_names(std::string_view head) {
  constexpr std::string_view kBegin = "<Label ";
  constexpr std::string_view kText = "<![CDATA[";
  std::size_t num_names = 0;
  for (auto at = head.find(kBegin); at != std::string_view::npos && num_names < kMaxNames;
       at = head.find(kBegin, at + 1), ++num_names) {
    const auto tag_end = head.find('>', at);
    if (tag_end == std::string_view::npos) return;
    const auto end = head.find("</Label>", tag_end);
    if (end == std::string_view::npos) return;
    const std::string_view tag = head.substr(at, tag_end - at);
    std::string_view text = head.substr(tag_end + 1, end - tag_end - 1);
    if (text.starts_with(kText)) text = text.substr(kText.size(), text.find("]]>") - kText.size());
    say({label_of(attribute(tag, "Key")),
         std::string(text),
         {attribute(tag, "Red"), attribute(tag, "Green"), attribute(tag, "Blue")}});
  }
}

}  // namespace

void say_label_names(const std::filesystem::path& path) {
  const std::string head = head_of(path);
  if (head.starts_with("NRRD")) return say_slicer_names(head);
  constexpr std::string_view kTable = "<LabelTable>";
  constexpr std::string_view kTableEnd = "</LabelTable>";
  const auto begin = head.find(kTable);
  const auto end = head.find(kTableEnd);
  if (begin != std::string::npos && end != std::string::npos && begin < end)
    say_table_names(std::string_view(head).substr(begin, end - begin));
}

}  // namespace mor::import
