// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "include_graph.h"

#include <fstream>
#include <functional>
#include <regex>

namespace mor {
namespace {

namespace fs = std::filesystem;

std::string module_of(const std::string& file) {
  return file.substr(0, file.find('/'));
}

std::string judge_include(const std::string& from, const std::string& to, const Layers& layers) {
  const auto from_layer = layers.find(module_of(from));
  const auto to_layer = layers.find(module_of(to));
  if (from_layer == layers.end()) return from + " is in a module without a layer";
  if (to_layer == layers.end()) return from + " includes " + to + ", a module without a layer";
  if (from_layer->first == to_layer->first) return {};
  if (to.find("/internal/") != std::string::npos) return from + " includes the internal " + to;
  if (to_layer->second > from_layer->second) return from + " includes upward " + to;
  if (to_layer->second == from_layer->second) return from + " includes sideways " + to;
  return {};
}

class CircleFinder {
 public:
  explicit CircleFinder(const IncludeGraph& graph) : graph_(graph) {}

  std::vector<std::string> find() {
    for (const auto& [file, includes] : graph_) visit(file);
    return circles_;
  }

 private:
  void visit(const std::string& file) {
    if (done_.count(file) != 0) return;
    if (!open_.insert(file).second) {
      circles_.push_back(file + " includes itself in a circle");
      return;
    }
    if (const auto includes = graph_.find(file); includes != graph_.end()) {
      for (const auto& next : includes->second) visit(next);
    }
    open_.erase(file);
    done_.insert(file);
  }

  const IncludeGraph& graph_;
  std::set<std::string> open_;
  std::set<std::string> done_;
  std::vector<std::string> circles_;
};

}  // namespace

IncludeGraph read_include_graph(const fs::path& source) {
  static const std::regex kInclude("^\\s*#\\s*include\\s*\"morgagni/([^\"]+)\".*");
  IncludeGraph graph;
  for (const auto& entry : fs::recursive_directory_iterator(source)) {
    const auto extension = entry.path().extension();
    if (extension != ".h" && extension != ".cc") continue;
    auto& includes = graph[fs::relative(entry.path(), source).generic_string()];
    std::ifstream in(entry.path());
    std::smatch match;
    for (std::string line; std::getline(in, line);) {
      if (std::regex_match(line, match, kInclude)) includes.insert(match[1]);
    }
  }
  return graph;
}

std::vector<std::string> find_violations(const IncludeGraph& graph, const Layers& layers) {
  std::vector<std::string> violations = CircleFinder(graph).find();
  for (const auto& [file, includes] : graph) {
    for (const auto& included : includes) {
      if (auto sentence = judge_include(file, included, layers); !sentence.empty()) {
        violations.push_back(std::move(sentence));
      }
    }
  }
  return violations;
}

}  // namespace mor
