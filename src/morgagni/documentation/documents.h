// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "morgagni/core/progress.h"
#include "morgagni/core/result.h"
#include "morgagni/documentation/export_model.h"
#include "morgagni/documentation/finding.h"
#include "morgagni/documentation/printable.h"
#include "morgagni/documentation/skin_texture.h"
#include "morgagni/geometry/volume.h"

namespace mor {

enum class DocumentFormat : std::uint8_t { kGlb, kObj, kPly, kStl, k3mf, kViewer, kPdf };

inline constexpr std::array kDocumentFormats = {DocumentFormat::kGlb,
                                                DocumentFormat::kObj,
                                                DocumentFormat::kPly,
                                                DocumentFormat::kStl,
                                                DocumentFormat::k3mf,
                                                DocumentFormat::kViewer,
                                                DocumentFormat::kPdf};

[[nodiscard]] std::string_view to_string(DocumentFormat format);  ///< "glb", ..., "viewer", "pdf".
[[nodiscard]] std::optional<DocumentFormat> parse_document_format(std::string_view name);

/// Something that is known of a case, in words for people.
struct DocumentFact {
  std::string name;
  std::string value;
};

/// A file and the proof that it is the one.
struct HashedFile {
  std::string name;  ///< Relative to its folder.
  std::uintmax_t num_bytes = 0;
  std::string sha256;
};

/// A picture that was kept with the case.
struct DocumentPicture {
  std::filesystem::path file;  ///< PNG.
  std::string caption;
};

/// What is known of a case, as the documents tell it.
struct DocumentSource {
  std::string case_name;
  std::string ct_description;
  std::vector<DocumentFact> facts;  ///< CT, preparation, calibration, ...
  std::vector<HashedFile> case_files;
  TriangleMesh skin;
  std::optional<SkinTexture> texture;  ///< None: the skin is plain, and the documents say so.
  std::vector<ExportSurface> structures;
  std::shared_ptr<const Volume> volume;  ///< None: the viewer has no slices.
  std::vector<Finding> findings;
  std::filesystem::path findings_folder;  ///< Where their photos lie.
  std::vector<DocumentPicture> pictures;
};

struct DocumentOptions {
  std::vector<DocumentFormat> formats{kDocumentFormats.begin(), kDocumentFormats.end()};
  PrintOptions print;
  std::string author;                     ///< Who takes the documents away; empty: not said.
  std::filesystem::path viewer_template;  ///< The built viewer page (web/viewer).

  [[nodiscard]] Result<void> check() const;
};

/// What was made.
struct DocumentSummary {
  std::filesystem::path folder;
  std::vector<HashedFile> files;     ///< In the order of their making; manifest.json last.
  std::vector<std::string> remarks;  ///< Sentences on what is not as one might expect.
};

/// What the manifest is called; a folder with it is one of documents.
inline constexpr const char* kManifestFile = "manifest.json";

/// Makes the documents of a case in a new folder: written aside and put in its place in one step,
/// so that it is there whole or not at all.
///
/// @param folder  Replaced when it holds documents already.
/// @param stop    Looked at between steps of about a second.
/// @errors kInvalidArgument: options; `folder` exists and holds something else; broken meshes or
///         texture. kIo: no permission, disk full. kNotFound: the viewer page is not built.
///         kCancelled: stopped; nothing is left.
[[nodiscard]] Result<DocumentSummary> make_documents(const DocumentSource& source,
                                                     const std::filesystem::path& folder,
                                                     const DocumentOptions& options,
                                                     const Progress& progress,
                                                     std::stop_token stop);

}  // namespace mor
