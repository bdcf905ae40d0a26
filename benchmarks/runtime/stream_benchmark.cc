// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// What the stream adds to a picture's age: from show() to the encoded VP8 picture, alone on the
// machine. The network and the browser are measured by web/tests/e2e/stream_test.mjs.

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include <benchmark/benchmark.h>

#include "morgagni/stream/live_server.h"
#include "morgagni/stream/testing/test_pattern.h"

namespace {

using std::chrono::steady_clock;

/// A page of one line: the benchmark needs none, the server does.
std::filesystem::path make_web_root() {
  const auto root = std::filesystem::temp_directory_path() / "morgagni_stream_benchmark";
  std::filesystem::create_directories(root);
  std::ofstream(root / "index.html") << "<p>benchmark</p>";
  return root;
}

void BM_ShowToEncoded(benchmark::State& state) {
  const auto server = mor::LiveServer::start({.port = 0, .web_root = make_web_root()}, {});
  if (!server) {
    state.SkipWithError(server.error().message.c_str());
    return;
  }
  mor::testing::TestPattern pattern(static_cast<int>(state.range(0)),
                                    static_cast<int>(state.range(1)));
  std::uint32_t number = 0;
  for (auto _ : state) {
    const auto picture = pattern.draw(++number);
    const auto encoded_before = (*server)->stats().num_encoded;
    const auto begin = steady_clock::now();
    (*server)->show(picture, {begin, "{}"});
    while ((*server)->stats().num_encoded == encoded_before) std::this_thread::yield();
    state.SetIterationTime(std::chrono::duration<double>(steady_clock::now() - begin).count());
  }
  const auto stats = (*server)->stats();
  state.counters["p50_ms"] = stats.capture_to_encoded_ms;
  state.counters["p95_ms"] = stats.capture_to_encoded_p95_ms;
}

BENCHMARK(BM_ShowToEncoded)
    ->ArgNames({"width", "height"})
    ->Args({640, 480})
    ->Args({1280, 720})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(120);

}  // namespace
