// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "include_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Layers& layers() {
  static const Layers kLayers = {{"core", 0},
                                 {"geometry", 1},
                                 {"compute", 1},
                                 {"ct", 2},
                                 {"camera", 2},
                                 {"depth", 2},
                                 {"render", 2},
                                 {"stream", 2},
                                 {"pacs", 2},
                                 {"registration", 2},
                                 {"tracking", 3},
                                 {"documentation", 3},
                                 {"casefile", 3},
                                 {"calibration", 3},
                                 {"evaluation", 4},
                                 {"session", 5}};
  return kLayers;
}

TEST(IncludeGraph, OfTheProgramFlowsOneWay) {
  const auto graph = read_include_graph(MORGAGNI_SOURCE_DIR "/src/morgagni");
  ASSERT_GT(graph.size(), 50U) << "the sources were not found";
  EXPECT_THAT(find_violations(graph, layers()), IsEmpty());
}

TEST(IncludeGraph, FindsAnUpwardInclude) {
  EXPECT_THAT(find_violations({{"core/a.h", {"geometry/b.h"}}}, layers()),
              ElementsAre("core/a.h includes upward geometry/b.h"));
}

TEST(IncludeGraph, FindsASidewaysInclude) {
  EXPECT_THAT(find_violations({{"depth/a.cc", {"camera/b.h"}}}, layers()),
              ElementsAre("depth/a.cc includes sideways camera/b.h"));
}

TEST(IncludeGraph, FindsACircle) {
  const IncludeGraph graph = {
      {"core/a.h", {"core/b.h"}}, {"core/b.h", {"core/c.h"}}, {"core/c.h", {"core/a.h"}}};
  EXPECT_THAT(find_violations(graph, layers()), ElementsAre(HasSubstr("in a circle")));
}

TEST(IncludeGraph, FindsAnothersInternalFile) {
  EXPECT_THAT(find_violations({{"session/a.cc", {"render/internal/b.h"}}}, layers()),
              ElementsAre(HasSubstr("internal")));
}

TEST(IncludeGraph, FindsAModuleWithoutALayer) {
  EXPECT_THAT(find_violations({{"utils/a.h", {"core/b.h"}}}, layers()),
              ElementsAre(HasSubstr("without a layer")));
}

TEST(IncludeGraph, AllowsDownwardAndOwnIncludes) {
  EXPECT_THAT(find_violations({{"depth/a.cc", {"depth/internal/b.h", "geometry/c.h"}}}, layers()),
              IsEmpty());
}

}  // namespace
}  // namespace mor
