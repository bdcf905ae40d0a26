// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/added_cts.h"
#include "morgagni/casefile/case.h"
#include "morgagni/casefile/prepare.h"
#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/kept_memory.h"
#include "morgagni/core/progress.h"
#include "morgagni/session/skin_check.h"

#include "commands.h"
#include "exit.h"
#include "options.h"
#include "stop_signals.h"

namespace mor {
namespace {

const std::map<std::string, MeshFrame> kFrames = {{"lps", MeshFrame::kLps},
                                                  {"ras", MeshFrame::kRas}};

struct Arguments {
  std::filesystem::path ct;
  std::filesystem::path folder;
  std::string add;
  std::filesystem::path preview;
  bool list_series = false;
  bool check = false;
  std::vector<std::string> keep;
  std::vector<std::string> cut;
  std::vector<std::string> take_off;
  SkinCheckOptions page;
  PrepareOptions options;
};

/// The same letter (from the 27th on, number) for the same frame of reference; "-": not known.
class FrameLetters {
 public:
  std::string of(const std::string& uid) {
    if (uid.empty()) return "-";
    const auto idx = letters_.try_emplace(uid, letters_.size()).first->second;
    return idx < 26 ? std::string(1, static_cast<char>('A' + idx)) : std::to_string(idx + 1);
  }

 private:
  std::map<std::string, std::size_t> letters_;
};

void list_series(const std::filesystem::path& ct) {
  const auto all = value_or_exit(list_ct_series(ct, {}));
  FrameLetters letters;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& series = all[i];
    fmt::print(
        "{}  \"{}\"  {} slices of {}x{}, {:.2f} to {:.2f} mm apart, {}, coordinates {}, patient "
        "{}, "
        "{}\n",
        i + 1,
        series.description,
        series.num_slices,
        series.columns,
        series.rows,
        series.min_gap_mm,
        series.max_gap_mm,
        series.patient_position.empty() ? "no position" : series.patient_position,
        letters.of(series.frame_of_reference_uid),
        series.patient_id,
        series.uid);
  }
}

void print_cut(const std::vector<CutPart>& cut) {
  for (const auto& part : cut) {
    fmt::print("not the body: {:.0f} ml {} it, {:.0f} x {:.0f} x {:.0f} mm\n",
               part.volume_ml,
               part.place,
               part.size_mm.x(),
               part.size_mm.y(),
               part.size_mm.z());
  }
}

void print_doubts(const std::vector<SkinDoubt>& doubts) {
  constexpr std::array<const char*, 4> kWhy = {"what lay on it was taken off",
                                               "a thin layer was taken off it",
                                               "a thin layer was taken off it, as you said",
                                               "a thin layer may lie on it, unseen (--take-off)"};
  for (const auto& doubt : doubts) {
    fmt::print(
        "skin not certain: {:.0f} cm2 at the {} ({:.0f},{:.0f},{:.0f}), by up to {:.1f} mm: {}\n",
        doubt.area_cm2,
        doubt.place,
        doubt.middle_mm.x(),
        doubt.middle_mm.y(),
        doubt.middle_mm.z(),
        doubt.up_to_mm,
        kWhy[static_cast<std::size_t>(doubt.why)]);
  }
}

void preview(const Arguments& arguments) {
  const auto progress = console_progress();
  const auto volume = value_or_exit(import_volume(arguments.ct, arguments.options.ct, progress));
  const auto body = value_or_exit(preview_body(volume, arguments.options.skin, progress));
  value_or_exit(write_file(arguments.preview, encode_png(body.picture.view())));
  print_cut(body.cut);
  print_doubts(body.doubts);
  fmt::print("{}: the body has a green outline (orange: not certain), what is cut off is red\n",
             arguments.preview.string());
}

void print_summary(const Arguments& arguments, const PrepareSummary& summary) {
  fmt::print(
      "{}: skin of {} vertices (from {}), bones of {} triangles; read in {:.1f} s, prepared in "
      "{:.1f} s\n",
      arguments.folder.string(),
      summary.num_skin_vertices,
      summary.num_full_skin_vertices,
      summary.num_bone_triangles,
      summary.reading_seconds,
      summary.seconds);
  print_cut(summary.cut);
  print_doubts(summary.doubts);
  if (!summary.structure_names.empty())
    fmt::print("structures: bone, {}\n", fmt::join(summary.structure_names, ", "));
}

void prepare(const Arguments& arguments) {
  print_summary(arguments,
                value_or_exit(prepare_case(
                    arguments.ct, arguments.folder, arguments.options, console_progress())));
}

/// The skin is looked at and corrected on a page before the case is made.
void check(Arguments& arguments) {
  value_or_exit(arguments.options.check());
  value_or_exit(check_case_folder(arguments.folder));
  StopSignals signals;
  const auto started = std::chrono::steady_clock::now();
  const auto volume = std::make_shared<const Volume>(value_or_exit(signals.at_once(
      [&] { return import_volume(arguments.ct, arguments.options.ct, console_progress()); })));
  const std::chrono::duration<double> reading = std::chrono::steady_clock::now() - started;
  const auto use = [&](const PrepareOptions& options, const Progress& progress) {
    return signals.at_once(
        [&] { return prepare_case(*volume, arguments.ct, arguments.folder, options, progress); });
  };
  auto& page = arguments.page;
  page.title = arguments.folder.string();
  page.prepare = arguments.options;
  if (page.server.web_root.empty()) page.server.web_root = default_web_root();
  const auto session = value_or_exit(SkinCheck::start(volume, use, page));
  fmt::print("Check the skin at http://127.0.0.1:{}/prepare.html  (Ctrl-C: nothing is made)\n",
             session->port());
  std::fflush(stdout);
  auto summary = session->wait(signals.token());
  if (!summary) {
    fmt::print("nothing was made\n");
    throw CLI::RuntimeError(kExitFailure);
  }
  summary->reading_seconds = reading.count();
  print_summary(arguments, *summary);
}

Eigen::Vector3d place_option(const std::string& name, const std::string& text) {
  Eigen::Vector3d place;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &place.x(), &place.y(), &place.z(), &rest) == 3)
    return place;
  return value_or_exit(Result<Eigen::Vector3d>(
      make_error(ErrorCode::kInvalidArgument,
                 fmt::format("{} must be X,Y,Z in mm (LPS), got \"{}\"", name, text))));
}

/// Of a further CT of a case that is there.
std::filesystem::path folder_to_add(const Arguments& arguments) {
  value_or_exit(load_case(arguments.folder));
  const auto folder = value_or_exit(ct_folder(arguments.folder, arguments.add));
  std::error_code status;
  std::filesystem::create_directory(folder.parent_path(), status);
  return folder;
}

void run(Arguments& arguments, bool has_folder) {
  auto& skin = arguments.options.skin;
  for (const auto& text : arguments.keep) skin.keep_mm.push_back(place_option("--keep", text));
  for (const auto& text : arguments.take_off)
    skin.take_off_mm.push_back(place_option("--take-off", text));
  for (const auto& text : arguments.cut) skin.cut_mm.push_back(place_option("--cut", text));
  if (arguments.list_series) return list_series(arguments.ct);
  keep_freed_memory();
  if (!arguments.preview.empty()) return preview(arguments);
  if (!has_folder) throw CLI::RequiredError("--case");
  if (!arguments.add.empty()) arguments.folder = folder_to_add(arguments);
  if (arguments.check) return check(arguments);
  prepare(arguments);
}

}  // namespace

void add_prepare_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  arguments->page.server.port = 0;
  auto* command =
      app.add_subcommand("prepare", "Make a case from a CT: skin, bones, distance field");
  command
      ->add_option("CT",
                   arguments->ct,
                   "DICOM folder, DICOMDIR, .zip or multi-frame file, or a NIfTI, NRRD or "
                   "MetaImage file")
      ->required();
  auto* folder = command->add_option(
      "--case", arguments->folder, "Folder of the case; replaced if it is one already");
  command
      ->add_option(
          "--add",
          arguments->add,
          "Add the CT to the case under this name, beside its first one (another part of the "
          "body, before an intervention): `serve --ct NAME` shows it")
      ->needs(folder);
  auto* series =
      command->add_option("--series",
                          arguments->options.ct.series,
                          "Of several DICOM series: number in the list, UID or description");
  series->excludes(
      command->add_flag("--list-series", arguments->list_series, "List the DICOM series and stop"));
  auto* join =
      command
          ->add_option(
              "--join",
              arguments->options.ct.join,
              "With --series: a further series of the same body that overlaps it, joined with it "
              "by their coordinates; may be given several times")
          ->expected(1)
          ->take_all()
          ->needs(series);
  command
      ->add_flag("--align-series",
                 arguments->options.ct.align,
                 "Join series by what both show (shifted table, feet first, turned over); refused "
                 "where they do not fit")
      ->needs(join);
  auto* labels =
      command
          ->add_option("--labels",
                       arguments->options.label_maps,
                       "Structures: a label map (NIfTI, NRRD, MetaImage, DICOM Segmentation or RT "
                       "Structure Set) made from this "
                       "CT; may be given several times")
          ->expected(1)
          ->take_all();
  auto* structure =
      command
          ->add_option(
              "--structure",
              arguments->options.meshes,
              "Structures: a surface (STL, OBJ, PLY, VTP) in this CT's millimetres; may be given "
              "several times")
          ->expected(1)
          ->take_all();
  command
      ->add_option("--structure-frame",
                   arguments->options.mesh.frame,
                   "Frame of the surfaces that do not name theirs: lps (DICOM) or ras (NIfTI)")
      ->transform(CLI::CheckedTransformer(kFrames).description("lps or ras"))
      ->default_str("lps")
      ->needs(structure);
  command
      ->add_flag("--total-segmentator",
                 arguments->options.total_segmentator,
                 "Labels without names have TotalSegmentator's (task \"total\")")
      ->needs(labels);
  command->add_option("--preview",
                      arguments->preview,
                      "Only draw what would be taken for the body into this PNG, and stop");
  auto* check = command->add_flag(
      "--check",
      arguments->check,
      "First show on a page what would be taken for the body, to correct it there");
  command->add_option("--port", arguments->page.server.port, "--check: on 127.0.0.1; 0: a free one")
      ->capture_default_str()
      ->needs(check);
  command->add_option("--web", arguments->page.server.web_root, "--check: the built page")
      ->type_name("DIR")
      ->needs(check);
  command
      ->add_option("--keep",
                   arguments->keep,
                   "A place (X,Y,Z in mm, LPS) in something that would be cut off and is kept, for "
                   "instance an arm beside the trunk; may be given several times")
      ->expected(1)
      ->take_all();
  command
      ->add_option(
          "--cut",
          arguments->cut,
          "A place in something that stands out from the body and is cut off, for instance "
          "a tube; may be given several times")
      ->expected(1)
      ->take_all();
  command
      ->add_option("--take-off",
                   arguments->take_off,
                   "A place of the skin where a thin layer may go on unseen (doubtful_skin), that "
                   "is taken off there; may be given several times")
      ->expected(1)
      ->take_all();
  auto& skin = arguments->options.skin;
  auto& bone = arguments->options.bone;
  command->add_option("--vertices", skin.num_vertices, "Vertices of the remeshed skin")
      ->capture_default_str();
  command->add_option("--threshold-hu", skin.threshold_hu, "Skin: body is at or above")
      ->capture_default_str();
  command->add_option("--upper-hu", skin.upper_hu, "Skin: body is at or below")
      ->capture_default_str();
  command->add_option("--closing-mm", skin.closing_mm, "Skin: radius of the closing")
      ->capture_default_str();
  command->add_option("--sub-sampling", skin.sub_sampling, "Remeshing: input vertices per cluster")
      ->capture_default_str();
  command
      ->add_option("--gradation", skin.gradation, "Remeshing: 0 uniform, larger follows curvature")
      ->capture_default_str();
  command->add_option("--bone-hu", bone.threshold_hu, "Bone is at or above")->capture_default_str();
  command->add_option("--bone-triangles", bone.num_triangles, "Triangles of the bones")
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  morgagni prepare /media/cd/DICOM --list-series\n"
      "  morgagni prepare /media/cd/DICOM --series 2 --case cases/0815\n"
      "  morgagni prepare /media/cd/DICOM --series head --join torso --case cases/0815\n"
      "  morgagni prepare /media/cd/DICOM --case cases/0815 --check\n"
      "  morgagni prepare before.nii.gz --case cases/0815 --add before\n"
      "  morgagni prepare head.nii.gz --preview body.png --threshold-hu -250\n"
      "  morgagni prepare chest.nii.gz --case cases/chest --labels organs.nii.gz "
      "--total-segmentator\n"
      "  morgagni prepare head.nii.gz --case cases/head --structure bullet.stl "
      "--structure-frame ras\n"
      "  morgagni prepare head.nii.gz --case cases/head --threshold-hu -250");
  command->callback([arguments, folder] { run(*arguments, folder->count() > 0); });
}

}  // namespace mor
