// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/documents.h"

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/image_png.h"
#include "morgagni/core/pending_folder.h"
#include "morgagni/core/utc.h"
#include "morgagni/core/version.h"
#include "morgagni/documentation/export_formats.h"
#include "morgagni/documentation/report.h"
#include "morgagni/documentation/viewer.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A structure's name as a file name: plain letters, digits, '-' and '_'.
std::string file_name(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '-' || c == '_';
    if (is_plain) {
      result += c;
    } else if (result.empty() || result.back() != '_') {
      result += '_';
    }
  }
  return result.substr(0, 60);
}

Result<void> check_target(const fs::path& folder) {
  std::error_code status;
  if (!fs::exists(folder, status) || fs::exists(folder / kManifestFile, status)) return {};
  if (fs::is_directory(folder, status) && fs::is_empty(folder, status)) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("{} exists and holds no documents (it has no {}): name another "
                                "folder",
                                folder.string(),
                                kManifestFile));
}

/// Makes one kind of document after the other in a folder that is not yet in its place.
class Maker {
 public:
  Maker(const DocumentSource& source,
        const DocumentOptions& options,
        const fs::path& folder,
        const Progress& progress,
        std::stop_token stop)
      : source_(source),
        options_(options),
        folder_(folder),
        progress_(progress),
        stop_(std::move(stop)),
        title_{source.case_name, utc_text()} {}

  Result<DocumentSummary> make() {
    MOR_CHECK(begin("surfaces"));
    MOR_TRY(model_,
            make_export_model(
                source_.skin, source_.texture ? &*source_.texture : nullptr, source_.structures));
    remark_on_texture();
    if (wants(DocumentFormat::kGlb)) MOR_CHECK(make_glb());
    if (wants(DocumentFormat::kObj)) MOR_CHECK(make_obj());
    if (wants(DocumentFormat::kPly)) MOR_CHECK(make_ply());
    if (wants(DocumentFormat::kStl)) MOR_CHECK(make_stl());
    if (wants(DocumentFormat::kStl) || wants(DocumentFormat::k3mf)) MOR_CHECK(make_print());
    if (wants(DocumentFormat::kViewer)) MOR_CHECK(make_viewer());
    if (wants(DocumentFormat::kPdf)) MOR_CHECK(make_report());
    MOR_CHECK(begin("manifest"));
    MOR_CHECK(add(kManifestFile, manifest()));
    progress_("manifest", 1.0);
    return std::move(summary_);
  }

 private:
  bool wants(DocumentFormat format) const {
    return std::find(options_.formats.begin(), options_.formats.end(), format) !=
           options_.formats.end();
  }

  Result<void> begin(std::string_view stage, double fraction = 0.0) {
    if (stop_.stop_requested())
      return make_error(ErrorCode::kCancelled, "stopped: no documents were made");
    progress_(stage, fraction);
    return {};
  }

  Result<void> add(const std::string& name, const std::string& bytes) {
    MOR_CHECK(write_file(folder_ / name, bytes));
    summary_.files.push_back({name, bytes.size(), sha256_hex(std::as_bytes(std::span(bytes)))});
    return {};
  }

  Result<void> add(const std::string& name, const Result<std::string>& bytes) {
    if (!bytes) return tl::unexpected<Error>(bytes.error());
    return add(name, *bytes);
  }

  void remark_on_texture() {
    if (model_.picture.empty()) {
      summary_.remarks.emplace_back(
          "The case has no fused texture: the skin has one plain colour, which is not the body's.");
    } else {
      summary_.remarks.push_back(
          fmt::format("{:.0f} % of the skin was seen by the camera; the rest is grey.",
                      100.0 * model_.seen_share));
    }
  }

  Result<void> make_glb() {
    MOR_CHECK(begin("GLB"));
    MOR_CHECK(add("model.glb", encode_glb(model_, title_)));
    progress_("GLB", 1.0);
    return {};
  }

  Result<void> make_obj() {
    MOR_CHECK(begin("OBJ"));
    MOR_CHECK(add("model.obj", encode_obj(model_, title_, "model.mtl")));
    MOR_CHECK(add("model.mtl", encode_mtl(model_, "skin.png")));
    if (!model_.picture.empty()) {
      const auto png = encode_png(model_.picture.view());
      MOR_CHECK(
          add("skin.png", std::string(reinterpret_cast<const char*>(png.data()), png.size())));
    }
    progress_("OBJ", 1.0);
    return {};
  }

  /// A name of its own for each structure's file, without extension.
  std::vector<std::string> structure_files() const {
    std::set<std::string> taken = {"skin", "skin-print", "structures", "model"};
    std::vector<std::string> names;
    for (const auto& structure : model_.structures) {
      const std::string base = file_name(structure.name);
      std::string name = base;
      for (int i = 2; !taken.insert(name).second; ++i) name = fmt::format("{}-{}", base, i);
      names.push_back(name);
    }
    return names;
  }

  Result<void> make_ply() {
    MOR_CHECK(begin("PLY"));
    MOR_CHECK(add("skin.ply", encode_colored_ply(model_.skin, model_.picture, title_)));
    const auto names = structure_files();
    for (std::size_t i = 0; i < names.size(); ++i) {
      MOR_CHECK(begin("PLY", static_cast<double>(i + 1) / static_cast<double>(names.size() + 1)));
      MOR_CHECK(add(names[i] + ".ply", encode_colored_ply(model_.structures[i], {}, title_)));
    }
    progress_("PLY", 1.0);
    return {};
  }

  Result<void> make_stl() {
    MOR_CHECK(begin("STL"));
    MOR_CHECK(add("skin.stl", encode_stl(model_.skin_mesh, title_)));
    const auto names = structure_files();
    for (std::size_t i = 0; i < names.size(); ++i) {
      MOR_CHECK(begin("STL", static_cast<double>(i + 1) / static_cast<double>(names.size() + 1)));
      MOR_CHECK(add(names[i] + ".stl", encode_stl(model_.structures[i].mesh, title_)));
    }
    progress_("STL", 1.0);
    return {};
  }

  /// A skin that cannot be printed does not keep the other documents from being made.
  Result<void> make_print() {
    MOR_CHECK(begin("print"));
    const auto solid = make_printable(model_.skin_mesh, options_.print);
    if (solid) {
      remark_on_print(*solid);
      if (wants(DocumentFormat::kStl))
        MOR_CHECK(add("skin-print.stl", encode_stl(solid->mesh, title_)));
      if (wants(DocumentFormat::k3mf))
        MOR_CHECK(add("skin-print.3mf", encode_skin_3mf(model_, *solid, title_)));
    } else {
      summary_.remarks.push_back("Nothing to print was made: " + solid.error().message + ".");
    }
    if (wants(DocumentFormat::k3mf) && !model_.structures.empty())
      MOR_CHECK(add("structures.3mf", encode_structures_3mf(model_, title_)));
    progress_("print", 1.0);
    return {};
  }

  void remark_on_print(const PrintableSolid& solid) {
    const bool is_shell = options_.print.form == PrintForm::kShell;
    print_ = {{"form", is_shell ? "shell" : "filled"},
              {"open_ends", solid.num_open_ends},
              {"thinnest_mm", solid.thinnest_mm},
              {"manifold", true}};
    if (is_shell) {
      print_["wall_mm"] = options_.print.wall_mm;
      print_["thin_share"] = solid.thin_share;
    }
    const std::string ends = solid.num_open_ends == 0
                                 ? std::string("The CT's skin is closed")
                                 : fmt::format("The CT's skin is open in {} {}, where the CT ends",
                                               solid.num_open_ends,
                                               solid.num_open_ends == 1 ? "place" : "places");
    std::string change = solid.num_open_ends == 0 ? "left as it is" : "closed by lids";
    if (is_shell) {
      change = fmt::format("made a wall of {:.1f} mm inwards ({:.0f} % of it had to be thinner)",
                           options_.print.wall_mm,
                           100.0 * solid.thin_share);
    }
    summary_.remarks.push_back(fmt::format(
        "{}; for printing it was {}; it is manifold, and 99 % of it is at least {:.1f} mm thick. "
        "Whether it cuts through itself was not looked at.",
        ends,
        change,
        solid.thinnest_mm));
  }

  Result<void> make_viewer() {
    MOR_CHECK(begin("viewer"));
    MOR_TRY(const auto page, fill_viewer(source_, model_, title_, options_.viewer_template));
    MOR_CHECK(begin("viewer", 0.9));
    MOR_CHECK(add("viewer.html", page.html));
    summary_.remarks.insert(summary_.remarks.end(), page.remarks.begin(), page.remarks.end());
    progress_("viewer", 1.0);
    return {};
  }

  Result<void> make_report() {
    MOR_CHECK(begin("report"));
    const Report report{source_, model_, title_, options_.author, summary_.files, summary_.remarks};
    MOR_TRY(const auto pdf, encode_report_pdf(report));
    MOR_CHECK(begin("report", 0.9));
    MOR_CHECK(add("report.pdf", pdf));
    progress_("report", 1.0);
    return {};
  }

  static Json files_json(const std::vector<HashedFile>& files) {
    Json list = Json::array();
    for (const auto& file : files)
      list.push_back({{"name", file.name}, {"bytes", file.num_bytes}, {"sha256", file.sha256}});
    return list;
  }

  std::string manifest() const {
    Json facts = Json::object();
    for (const auto& fact : source_.facts) facts[fact.name] = fact.value;
    Json texture = nullptr;
    if (source_.texture) {
      texture = {{"seen_share", model_.seen_share},
                 {"frames", source_.texture->frames.size()},
                 {"width_px", model_.picture.width()},
                 {"height_px", model_.picture.height()}};
    }
    const Json json = {{"format", 1},
                       {"made_by", std::string("Morgagni ") + kVersion},
                       {"made_at", title_.created_at},
                       {"author", options_.author},
                       {"notice", "Not a medical device."},
                       {"case", source_.case_name},
                       {"ct", source_.ct_description},
                       {"facts", facts},
                       {"texture", texture},
                       {"print", print_},
                       {"findings", source_.findings.size()},
                       {"remarks", summary_.remarks},
                       {"files", files_json(summary_.files)},
                       {"case_files", files_json(source_.case_files)}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  }

  const DocumentSource& source_;
  const DocumentOptions& options_;
  fs::path folder_;
  const Progress& progress_;
  std::stop_token stop_;
  ExportTitle title_;
  ExportModel model_;
  Json print_;
  DocumentSummary summary_;
};

}  // namespace

std::string_view to_string(DocumentFormat format) {
  switch (format) {
    case DocumentFormat::kGlb:
      return "glb";
    case DocumentFormat::kObj:
      return "obj";
    case DocumentFormat::kPly:
      return "ply";
    case DocumentFormat::kStl:
      return "stl";
    case DocumentFormat::k3mf:
      return "3mf";
    case DocumentFormat::kViewer:
      return "viewer";
    case DocumentFormat::kPdf:
      return "pdf";
  }
  return "";
}

std::optional<DocumentFormat> parse_document_format(std::string_view name) {
  for (const auto format : kDocumentFormats) {
    if (to_string(format) == name) return format;
  }
  return std::nullopt;
}

Result<void> DocumentOptions::check() const {
  MOR_CHECK(print.check());
  if (formats.empty())
    return make_error(ErrorCode::kInvalidArgument, "name at least one format of documents");
  return {};
}

Result<DocumentSummary> make_documents(const DocumentSource& source,
                                       const fs::path& folder,
                                       const DocumentOptions& options,
                                       const Progress& progress,
                                       std::stop_token stop) {
  MOR_CHECK(options.check());
  MOR_CHECK(check_target(folder));
  MOR_TRY(auto pending, PendingFolder::create(folder));
  MOR_TRY(auto summary, Maker(source, options, pending.path(), progress, std::move(stop)).make());
  MOR_CHECK(pending.commit());
  summary.folder = folder;
  return summary;
}

}  // namespace mor
