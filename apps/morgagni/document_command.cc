// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <spdlog/fmt/fmt.h>

#include "morgagni/casefile/added_cts.h"
#include "morgagni/casefile/case.h"
#include "morgagni/core/progress.h"
#include "morgagni/documentation/viewer.h"
#include "morgagni/session/document_case.h"

#include "commands.h"
#include "exit.h"
#include "options.h"
#include "stop_signals.h"

namespace mor {
namespace {

struct Arguments {
  std::filesystem::path folder;
  std::string ct;
  std::filesystem::path output;
  std::filesystem::path web;
  std::vector<std::string> formats;
  DocumentOptions options;
};

const std::map<std::string, PrintForm> kPrintForms = {{"filled", PrintForm::kFilled},
                                                      {"shell", PrintForm::kShell}};

std::string format_names() {
  std::string names;
  for (const auto format : kDocumentFormats)
    names += (names.empty() ? "" : ", ") + std::string(to_string(format));
  return names;
}

std::vector<DocumentFormat> formats_of(const std::vector<std::string>& names) {
  if (names.empty()) return {kDocumentFormats.begin(), kDocumentFormats.end()};
  std::vector<DocumentFormat> formats;
  for (const auto& name : names) {
    const auto format = parse_document_format(name);
    if (!format)
      value_or_exit(Result<void>(
          make_error(ErrorCode::kInvalidArgument,
                     fmt::format("--formats must be of {}, got \"{}\"", format_names(), name))));
    formats.push_back(*format);
  }
  return formats;
}

void document(Arguments& arguments) {
  arguments.options.formats = formats_of(arguments.formats);
  const auto web = arguments.web.empty() ? default_web_root() : arguments.web;
  arguments.options.viewer_template = web / kViewerFile;
  value_or_exit(arguments.options.check());
  const StopSignals signals;
  const auto body =
      value_or_exit(load_case(value_or_exit(find_ct(arguments.folder, arguments.ct))));
  const auto made = value_or_exit(document_case(
      body, arguments.output, arguments.options, console_progress(), signals.token()));
  for (const auto& file : made.files)
    fmt::print("{:>12}  {}\n", fmt::format("{:.1f} kB", file.num_bytes / 1e3), file.name);
  for (const auto& remark : made.remarks) fmt::print("{}\n", remark);
  fmt::print("{}: {} files, each with its SHA-256 in {}\n",
             made.folder.string(),
             made.files.size(),
             kManifestFile);
}

}  // namespace

void add_document_command(CLI::App& app) {
  auto arguments = std::make_shared<Arguments>();
  auto* command = app.add_subcommand(
      "document", "Take a case away: models, a viewer for any browser, a report");
  command->add_option("--case", arguments->folder, "Folder that `morgagni prepare` made")
      ->required();
  command->add_option(
      "--ct", arguments->ct, "Of a case with several CTs: which (default: the first)");
  command->add_option(
      "--output",
      arguments->output,
      "New folder for the documents, or one with older documents, which are replaced (default: "
      "CASE/documents/TIME)");
  command->add_option("--formats", arguments->formats, fmt::format("Which of {}", format_names()))
      ->delimiter(',')
      ->default_str("all");
  command->add_option("--author", arguments->options.author, "Who takes them away, for the report")
      ->default_str("the user's name");
  command
      ->add_option("--print",
                   arguments->options.print.form,
                   "stl, 3mf: the CT's skin is open where the CT ends; for printing its ends are "
                   "closed (filled), or it becomes a wall (shell)")
      ->transform(CLI::CheckedTransformer(kPrintForms).description("filled or shell"))
      ->default_str("filled");
  command->add_option("--wall-mm", arguments->options.print.wall_mm, "--print shell: its thickness")
      ->capture_default_str();
  command->add_option("--web", arguments->web, "The built page, with the viewer's")
      ->type_name("DIR");
  command->footer(
      "What comes out:\n"
      "  glb     skin with the fused texture, and structures; metres, y up; the picture is inside\n"
      "  obj     the same as text with materials and picture; millimetres, as all that follow\n"
      "  ply     skin and each structure, a colour a vertex\n"
      "  stl     skin and each structure without colours, and the skin closed for printing\n"
      "  3mf     the skin closed for printing in colours, and the structures\n"
      "  viewer  one HTML file: model, CT slices and findings in any browser, without network\n"
      "  pdf     a report: pictures with scale, findings, measurements, hashes\n"
      "A manifest.json with SHA-256 of everything is always beside them.\n"
      "\n"
      "Examples:\n"
      "  morgagni document --case cases/0815\n"
      "  morgagni document --case cases/0815 --formats viewer,pdf --author \"Dr. Jane Roe\"\n"
      "  morgagni document --case cases/head --formats 3mf --print shell --wall-mm 4 --output "
      "print");
  command->callback([arguments] {
    if (arguments->options.author.empty()) {
      const char* user = std::getenv("USER");
      arguments->options.author = user != nullptr ? user : "";
    }
    document(*arguments);
  });
}

}  // namespace mor
