// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/import_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "morgagni/core/log.h"
#include "morgagni/core/printable_text.h"
#include "morgagni/core/unique_fd.h"
#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/volume_header.h"

namespace mor::internal {
namespace {

constexpr std::string_view kStage = "read CT";
constexpr std::size_t kMaxLineBytes = 4096;
constexpr int kMaxNotes = 20;
constexpr std::size_t kMaxSeries = 1000;
constexpr std::size_t kMaxLabels = 1000;
constexpr int kMaxMaps = 200;

/// The same file on a number that the two fixed ones of the protocol cannot overwrite.
int above_the_fixed_ones(int fd) {
  const UniqueFd original(fd);
  return ::fcntl(fd, F_DUPFD_CLOEXEC, kImportVoxelsFd + 1);
}

/// What the child has said so far.
struct Talk {
  std::string pending;
  std::string current_file;
  std::optional<Error> error;
  std::vector<CtSeries> series;
  std::vector<LabelName> labels;
  std::string frame;
  std::string weakness;
  int num_maps = 1;
  int num_notes = 0;
  bool broken = false;
};

Error error_of(std::string_view text) {
  int code = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), code);
  const std::size_t start = static_cast<std::size_t>(parsed.ptr - text.data());
  if (parsed.ec != std::errc() || code < 0 || code > static_cast<int>(ErrorCode::kInternal))
    return {ErrorCode::kIo, std::string(text)};
  return {static_cast<ErrorCode>(code), std::string(text.substr(std::min(start + 1, text.size())))};
}

template <class Number>
Number number_of(std::string_view text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// None where the line has not all of its fields.
std::optional<CtSeries> series_of(std::string_view text) {
  std::vector<std::string> fields;
  for (std::size_t end; (end = text.find('\t')) != std::string_view::npos;
       text.remove_prefix(end + 1))
    fields.emplace_back(text.substr(0, end));
  constexpr std::size_t kNumFields = 10;
  if (fields.size() != kNumFields) return std::nullopt;
  CtSeries series;
  for (auto& field : fields) field = printable_text(field);
  series.uid = fields[0];
  series.description = fields[1];
  series.patient_id = fields[2];
  series.patient_position = fields[3];
  series.num_slices = number_of<int>(fields[4]);
  series.columns = number_of<int>(fields[5]);
  series.rows = number_of<int>(fields[6]);
  series.min_gap_mm = number_of<double>(fields[7]);
  series.max_gap_mm = number_of<double>(fields[8]);
  series.frame_of_reference_uid = fields[9];
  return series;
}

/// "5 0.5 0.2 0.1 liver"; none where it has not all of that.
std::optional<LabelName> label_of(std::string_view text) {
  std::array<double, 4> numbers{};
  for (double& number : numbers) {
    const auto end = text.find(' ');
    if (end == std::string_view::npos) return std::nullopt;
    number = number_of<double>(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
  if (!(numbers[0] >= 1.0 && numbers[0] <= 32767.0) || text.empty()) return std::nullopt;
  constexpr std::size_t kMaxNameBytes = 80;
  LabelName label{static_cast<int>(numbers[0]), printable_text(text.substr(0, kMaxNameBytes)), {}};
  for (int channel = 0; channel < 3; ++channel) {
    const double share = numbers[static_cast<std::size_t>(channel) + 1];
    label.color[channel] = share >= 0.0 ? static_cast<float>(std::min(share, 1.0)) : 0.0F;
  }
  return label;
}

void hear_line(std::string_view line, Talk& talk, const Progress& progress) {
  if (line.size() < 3 || line[1] != ' ') return;
  const std::string_view text = line.substr(2);
  if (line[0] == 'p') {
    double fraction = 0.0;
    if (std::from_chars(text.data(), text.data() + text.size(), fraction).ec == std::errc() &&
        fraction >= 0.0 && fraction < 1.0 && progress)
      progress(kStage, fraction);
  } else if (line[0] == 'f') {
    talk.current_file = printable_text(text);
  } else if (line[0] == 'n') {
    if (++talk.num_notes <= kMaxNotes) log::warn("{}", printable_text(text));
  } else if (line[0] == 'w') {
    talk.weakness = printable_text(text);
    static std::once_flag told;  // It is the machine's, not the file's.
    std::call_once(told, [&] { log::warn("{}", talk.weakness); });
  } else if (line[0] == 's') {
    if (auto series = series_of(text); series && talk.series.size() < kMaxSeries)
      talk.series.push_back(*std::move(series));
  } else if (line[0] == 'l') {
    if (auto label = label_of(text); label && talk.labels.size() < kMaxLabels)
      talk.labels.push_back(*std::move(label));
  } else if (line[0] == 'k') {
    talk.num_maps = std::clamp(number_of<int>(text), 1, kMaxMaps);
  } else if (line[0] == 'c') {
    talk.frame = text;
  } else if (line[0] == 'e' && !talk.error) {
    talk.error = error_of(printable_text(text));
  }
}

void hear(std::string_view bytes, Talk& talk, const Progress& progress) {
  talk.pending += bytes;
  std::size_t start = 0;
  for (std::size_t end; (end = talk.pending.find('\n', start)) != std::string::npos;
       start = end + 1)
    hear_line(std::string_view(talk.pending).substr(start, end - start), talk, progress);
  talk.pending.erase(0, start);
  if (talk.pending.size() > kMaxLineBytes) talk.broken = true;
}

/// Reads the pipe until the child closes it. False when the time is over.
bool listen_to_child(int pipe_fd,
                     std::chrono::steady_clock::time_point deadline,
                     Talk& talk,
                     const Progress& progress) {
  std::array<char, 4096> buffer;
  while (!talk.broken) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd waiting{pipe_fd, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(std::min<long>(left.count(), 60000)));
    if (ready <= 0) continue;
    const ssize_t num_bytes = ::read(pipe_fd, buffer.data(), buffer.size());
    if (num_bytes == 0 || (num_bytes < 0 && errno != EINTR)) break;
    if (num_bytes > 0) hear({buffer.data(), static_cast<std::size_t>(num_bytes)}, talk, progress);
  }
  return true;
}

/// Starts the program with only the three standard streams (to nowhere), the pipe and the memory
/// file: nothing else that this process has open is inherited.
Result<pid_t> spawn(const std::filesystem::path& program,
                    const ImportJob& job,
                    int messages_fd,
                    int voxels_fd) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDWR, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_RDWR, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_RDWR, 0);
  posix_spawn_file_actions_adddup2(&actions, messages_fd, kImportMessagesFd);
  posix_spawn_file_actions_adddup2(&actions, voxels_fd, kImportVoxelsFd);
  posix_spawn_file_actions_addclosefrom_np(&actions, kImportVoxelsFd + 1);
  std::string program_text = program.string();
  std::string task_text = job.task;
  std::string path_text = job.path.string();
  std::string series_text = job.series;
  std::array<char*, 5> arguments = {
      program_text.data(), task_text.data(), path_text.data(), series_text.data(), nullptr};
  pid_t child = -1;
  const int failure =
      ::posix_spawn(&child, program_text.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    return make_error(
        ErrorCode::kIo,
        "cannot start " + program_text + ": " + std::generic_category().message(failure));
  }
  return child;
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

bool read_exactly(int fd, void* into, std::size_t num_bytes, off_t offset) {
  auto* bytes = static_cast<char*>(into);
  while (num_bytes > 0) {
    const ssize_t got = ::pread(fd, bytes, num_bytes, offset);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes += got;
    offset += got;
    num_bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

Result<Volume> take_volume(int voxels_fd) {
  ImportHeader header;
  if (!read_exactly(voxels_fd, &header, sizeof(header), 0))
    return make_error(ErrorCode::kIo, "the import process gave no volume");
  MOR_TRY(Volume volume, volume_from_header(header));
  const std::size_t num_voxels = static_cast<std::size_t>(volume.size[0]) *
                                 static_cast<std::size_t>(volume.size[1]) *
                                 static_cast<std::size_t>(volume.size[2]);
  struct stat info {};
  if (::fstat(voxels_fd, &info) != 0 ||
      static_cast<std::size_t>(info.st_size) != sizeof(header) + num_voxels * sizeof(std::int16_t))
    return make_error(ErrorCode::kIo, "the import process gave a volume of the wrong length");
  volume.hu.resize(num_voxels);
  if (!read_exactly(voxels_fd, volume.hu.data(), num_voxels * sizeof(std::int16_t), sizeof(header)))
    return make_error(ErrorCode::kIo, "the import process gave a volume of the wrong length");
  make_right_handed(volume);
  return volume;
}

Result<TriangleMesh> take_mesh(int fd) {
  const auto bad = make_error(ErrorCode::kIo, "the import process gave no sound mesh");
  ImportMeshHeader header;
  struct stat info {};
  if (!read_exactly(fd, &header, sizeof(header), 0) || header.magic != kImportMeshMagic ||
      header.num_triangles > kMaxMeshTriangles || header.num_vertices > 3 * kMaxMeshTriangles ||
      ::fstat(fd, &info) != 0)
    return bad;
  TriangleMesh mesh;
  const std::size_t num_vertex_bytes = header.num_vertices * sizeof(Eigen::Vector3f);
  const std::size_t num_triangle_bytes = header.num_triangles * sizeof(Triangle);
  if (static_cast<std::size_t>(info.st_size) !=
      sizeof(header) + num_vertex_bytes + num_triangle_bytes)
    return bad;
  mesh.vertices.resize(header.num_vertices);
  mesh.triangles.resize(header.num_triangles);
  const auto triangles_at = static_cast<off_t>(sizeof(header) + num_vertex_bytes);
  if (!read_exactly(fd, mesh.vertices.data(), num_vertex_bytes, sizeof(header)) ||
      !read_exactly(fd, mesh.triangles.data(), num_triangle_bytes, triangles_at))
    return bad;
  const auto is_bad = [&](const Triangle& triangle) {
    return std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t corner) {
      return corner >= mesh.vertices.size() || !mesh.vertices[corner].allFinite();
    });
  };
  if (std::any_of(mesh.triangles.begin(), mesh.triangles.end(), is_bad)) return bad;
  return mesh;
}

/// What is wrong with what was handed over is wrong with the file.
auto naming(const std::filesystem::path& path) {
  return [name = path.filename().string()](Error error) {
    error.message = name + ": " + error.message;
    return error;
  };
}

Error death_of_child(int status, const Talk& talk, const std::filesystem::path& path) {
  std::string how = "ended with code " + std::to_string(WEXITSTATUS(status));
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    how = std::string("died (") + ::strsignal(signal) +
          (signal == SIGXCPU  ? ", its time limit"
           : signal == SIGSYS ? ", it tried what reading a file does not take"
                              : "") +
          ")";
  }
  const std::string what = talk.current_file.empty() ? path.string() : talk.current_file;
  return {ErrorCode::kIo,
          "the import process " + how + " while reading " + what + ": the file may be damaged"};
}

/// Starts the program, hears it to its end and finds out how it ended.
Result<Talk> converse(const std::filesystem::path& program,
                      const ImportJob& job,
                      const UniqueFd& voxels,
                      std::chrono::seconds time_limit,
                      const Progress& progress) {
  std::array<int, 2> pipe_fds{};
  if (::pipe2(pipe_fds.data(), O_CLOEXEC) != 0)
    return make_error(ErrorCode::kIo, "cannot open a pipe to the import process");
  const UniqueFd messages(pipe_fds[0]);
  UniqueFd messages_of_child(above_the_fixed_ones(pipe_fds[1]));
  if (messages_of_child.get() < 0 || voxels.get() < 0)
    return make_error(ErrorCode::kIo, "cannot make a memory file for the import process");
  MOR_TRY(const pid_t child, spawn(program, job, messages_of_child.get(), voxels.get()));
  messages_of_child.reset();
  Talk talk;
  const auto deadline = std::chrono::steady_clock::now() + time_limit;
  const bool in_time = listen_to_child(messages.get(), deadline, talk, progress);
  if (!in_time || talk.broken) ::kill(child, SIGKILL);
  const int status = wait_for(child);
  if (!in_time) {
    return make_error(ErrorCode::kTimeout,
                      "reading " + job.path.string() + " took longer than " +
                          std::to_string(time_limit.count()) + " s");
  }
  if (talk.error) return tl::unexpected<Error>(*talk.error);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return tl::unexpected<Error>(death_of_child(status, talk, job.path));
  if (talk.num_notes > kMaxNotes) log::warn("{} more notes", talk.num_notes - kMaxNotes);
  return talk;
}

}  // namespace

Result<std::filesystem::path> find_import_program() {
  std::error_code failure;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", failure);
  if (failure) return make_error(ErrorCode::kInternal, "cannot find the running program's folder");
  const auto folder = self.parent_path();
  for (const auto& candidate :
       {folder / "morgagni-import", folder.parent_path() / "bin" / "morgagni-import"}) {
    if (::access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return make_error(ErrorCode::kNotFound,
                    "morgagni-import is not beside " + self.string() + ": build or install it");
}

Result<Volume> run_import_process(const std::filesystem::path& program,
                                  const ImportJob& job,
                                  std::chrono::seconds time_limit,
                                  const Progress& progress) {
  const UniqueFd voxels(above_the_fixed_ones(::memfd_create("morgagni-import", MFD_CLOEXEC)));
  MOR_TRY(const Talk talk, converse(program, job, voxels, time_limit, progress));
  MOR_TRY(Volume volume, take_volume(voxels.get()).map_error(naming(job.path)));
  if (progress) progress(kStage, 1.0);
  return volume;
}

Result<LabelMap> run_label_process(const std::filesystem::path& program,
                                   const ImportJob& job,
                                   std::chrono::seconds time_limit,
                                   const Progress& progress) {
  const UniqueFd voxels(above_the_fixed_ones(::memfd_create("morgagni-import", MFD_CLOEXEC)));
  MOR_TRY(Talk talk, converse(program, job, voxels, time_limit, progress));
  LabelMap labels;
  MOR_TRY(labels.voxels, take_volume(voxels.get()).map_error(naming(job.path)));
  labels.names = std::move(talk.labels);
  labels.num_in_file = talk.num_maps;
  if (progress) progress(kStage, 1.0);
  return labels;
}

Result<ImportedMesh> run_mesh_process(const std::filesystem::path& program,
                                      const ImportJob& job,
                                      std::chrono::seconds time_limit,
                                      const Progress& progress) {
  const UniqueFd memory(above_the_fixed_ones(::memfd_create("morgagni-import", MFD_CLOEXEC)));
  MOR_TRY(const Talk talk, converse(program, job, memory, time_limit, progress));
  MOR_TRY(TriangleMesh mesh, take_mesh(memory.get()).map_error(naming(job.path)));
  if (progress) progress(kStage, 1.0);
  return ImportedMesh{std::move(mesh), talk.frame};
}

Result<std::vector<CtSeries>> run_series_process(const std::filesystem::path& program,
                                                 const ImportJob& job,
                                                 std::chrono::seconds time_limit,
                                                 const Progress& progress) {
  const UniqueFd nothing(above_the_fixed_ones(::memfd_create("morgagni-import", MFD_CLOEXEC)));
  MOR_TRY(Talk talk, converse(program, job, nothing, time_limit, progress));
  if (progress) progress(kStage, 1.0);
  return std::move(talk.series);
}

Result<std::string> run_limits_process(const std::filesystem::path& program,
                                       std::chrono::seconds time_limit) {
  const UniqueFd nothing(above_the_fixed_ones(::memfd_create("morgagni-import", MFD_CLOEXEC)));
  MOR_TRY(Talk talk, converse(program, {kTryLimitsTask, "/dev/null", {}}, nothing, time_limit, {}));
  return std::move(talk.weakness);
}

}  // namespace mor::internal
