// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// 2,000 mutants of each format through the import process: each is read or refused with one clear
// sentence, within its memory and time, and no answer contradicts what its file declares.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <spawn.h>
#include <sys/wait.h>

#include "morgagni/core/log.h"
#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/import_process.h"
#include "morgagni/ct/testing/sample_files.h"

#include "declared.h"
#include "fork_server.h"
#include "mutation.h"
#include "packet.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr int kNumMutants = 2000;
constexpr std::int64_t kLimitMib = 256 + 2 * 16;  ///< So small a file may declare 16 MiB.
constexpr std::int64_t kLimitCpuUs = 5'000'000;

struct Peaks : fork_server::ImportPeaks {
  std::int64_t idle_rss_kib = 0;  ///< Of an import that does nothing.
};

class Mutants : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    spdlog::set_level(spdlog::level::err);  // Thousands of notes say nothing here.
    folder_ = fs::temp_directory_path() /
              (std::string("morgagni_mutants_") + GetParam() + "_" + std::to_string(::getpid()));
    fs::create_directories(folder_ / "series");
    socket_ = (folder_ / "socket").string();
    ::setenv(fork_server::kSocketVariable, socket_.c_str(), 1);
    std::string program = std::string(MORGAGNI_TEST_DIR) + "/import_fork_server";
    ::setenv("LD_BIND_NOW", "1", 1);  // Else each child looks for the same functions again.
    std::array<char*, 3> arguments = {program.data(), socket_.data(), nullptr};
    ASSERT_EQ(::posix_spawn(&server_, program.c_str(), nullptr, nullptr, arguments.data(), environ),
              0);
    for (int tries = 0; tries < 600 && peaks().num_imports < 0; ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ASSERT_EQ(peaks().num_imports, 0) << "the fork server does not answer";
  }
  void TearDown() override {
    ::kill(server_, SIGKILL);
    ::waitpid(server_, nullptr, 0);
    fs::remove_all(folder_);
  }

  /// num_imports is -1 where the server does not answer.
  [[nodiscard]] fork_server::ImportPeaks peaks() const {
    fork_server::ImportPeaks peaks;
    peaks.num_imports = -1;
    const int server = fork_server::connect_to(socket_);
    if (server < 0) return peaks;
    (void)::send(server, "?", 1, MSG_NOSIGNAL);
    if (::recv(server, &peaks, sizeof(peaks), 0) != sizeof(peaks)) peaks.num_imports = -1;
    ::close(server);
    return peaks;
  }

  fs::path write(const fs::path& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary | std::ios::trunc) << bytes;
    return folder_ / name;
  }

  fs::path folder_;
  std::string socket_;
  pid_t server_ = -1;
};

/// What the sentence of a refusal must be.
void expect_clear(const std::string& sentence, const fs::path& path) {
  EXPECT_THAT(sentence, HasSubstr(path.filename().string()));
  EXPECT_LT(sentence.size(), 500U);
  EXPECT_EQ(sentence.find_first_of("\n\r\t"), std::string::npos) << sentence;
  for (const char* jargon :
       {"itk", "gdcm", "::", "(0x", " 0x", "longer than", "std:", "gave no", "wrong length"})
    EXPECT_THAT(sentence, Not(HasSubstr(jargon)));
}

class Runs {
 public:
  explicit Runs(std::string format) : format_(std::move(format)) {}

  void run(const fs::path& path, const std::string& task, const std::string& bytes) {
    const std::filesystem::path program = std::string(MORGAGNI_TEST_DIR) + "/import_launcher";
    constexpr std::chrono::seconds kTimeLimit{60};
    const internal::ImportJob job = {task, path, {}};
    if (task == kReadMeshTask) {
      const auto mesh = internal::run_mesh_process(program, job, kTimeLimit, {});
      mesh ? accept(contradiction(format_, bytes, mesh->mesh)) : refuse(mesh.error(), path);
    } else if (task == kReadLabelsTask) {
      const auto labels = internal::run_label_process(program, job, kTimeLimit, {});
      labels ? accept({}) : refuse(labels.error(), path);
    } else {
      const auto volume = internal::run_import_process(program, job, kTimeLimit, {});
      const bool is_alone = path.filename().string().starts_with("alone");
      volume ? accept(is_alone ? "" : contradiction(format_, bytes, *volume))
             : refuse(volume.error(), path);
    }
  }

  [[nodiscard]] int num_read() const { return num_read_; }
  [[nodiscard]] int num_died() const { return num_died_; }
  [[nodiscard]] const std::string& last_death() const { return last_death_; }

 private:
  void accept(const std::string& contradiction) {
    ++num_read_;
    EXPECT_EQ(contradiction, "");
  }
  void refuse(const Error& error, const fs::path& path) {
    expect_clear(error.message, path);
    if (error.message.find("the import process") == std::string::npos) return;
    ++num_died_;
    last_death_ = error.message;
  }

  std::string format_;
  int num_read_ = 0;
  int num_died_ = 0;
  std::string last_death_;
};

std::size_t num_open_files() {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

TEST_P(Mutants, AreReadOrRefused) {
  const std::string format = GetParam();
  const bool is_mesh = format == "ply" || format == "stl" || format == "obj" || format == "vtp";
  const auto samples = testing_files::sample_files(format);
  for (const auto& slice : testing_files::sample_neighbours())
    write("series/" + slice.name, slice.bytes);
  std::mt19937 random(20261126);
  Runs runs(format);
  const auto open_before = num_open_files();
  for (int i = 0; i < kNumMutants; ++i) {
    SCOPED_TRACE("mutant " + std::to_string(i));
    const auto& sample = samples[static_cast<std::size_t>(i) % samples.size()];
    const std::string bytes = mutated(sample.bytes, random);
    const bool in_series = format == "dicom" && !sample.name.starts_with("alone");
    const auto path = write(in_series ? "series/2" : sample.name, bytes);
    const bool is_labels = format == "rtstruct" || sample.name == "alone_segments.dcm";
    runs.run(in_series ? path.parent_path() : path,
             is_mesh     ? kReadMeshTask
             : is_labels ? kReadLabelsTask
                         : kReadVolumeTask,
             bytes);
    if (HasFailure()) {
      fs::copy_file(path,
                    fs::temp_directory_path() / ("failed_mutant_" + path.filename().string()),
                    fs::copy_options::overwrite_existing);
      break;
    }
  }
  EXPECT_EQ(num_open_files(), open_before);
  const auto most = peaks();
  EXPECT_EQ(most.num_imports, kNumMutants);
  EXPECT_LT(most.max_rss_kib / 1024, kLimitMib);
  EXPECT_LT(most.max_cpu_us, kLimitCpuUs);
  EXPECT_GT(runs.num_read(), 0);
  EXPECT_LT(runs.num_read(), kNumMutants);
  EXPECT_EQ(most.num_killed, 0) << runs.last_death();
  EXPECT_EQ(runs.num_died(), 0) << runs.last_death();
  std::printf(
      "%s: %d mutants, %d read; at most %ld MiB and %ld ms of CPU time, %.2f ms in the mean\n",
      format.c_str(),
      kNumMutants,
      runs.num_read(),
      static_cast<long>(most.max_rss_kib / 1024),
      static_cast<long>(most.max_cpu_us / 1000),
      static_cast<double>(most.sum_cpu_us) / 1000.0 / kNumMutants);
}

INSTANTIATE_TEST_SUITE_P(
    Of,
    Mutants,
    testing::Values("dicom", "rtstruct", "nifti", "nrrd", "mha", "ply", "stl", "obj", "vtp"),
    [](const auto& of) { return std::string(of.param); });

}  // namespace
}  // namespace mor
