// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "morgagni/core/log.h"
#include "morgagni/core/version.h"

#include "commands.h"
#include "exit.h"

int main(int argc, char** argv) {
  CLI::App app{
      "Morgagni: look into a body with a depth camera. It aligns the camera's depth with the skin "
      "of the\n"
      "body's CT, without markers, and streams the picture back with the anatomy in its true "
      "place.\n"
      "Not a medical device.",
      "morgagni"};
  app.set_version_flag("--version", std::string("morgagni ") + mor::kVersion);
  bool verbose = false;
  app.add_flag("--verbose", verbose, "Log more, to standard error");
  app.parse_complete_callback([&] { mor::log::set_up(verbose); });
  app.require_subcommand(1);
  app.footer(
      "Example, from a CT to a live picture in the browser:\n"
      "  morgagni prepare ct/ --case cases/0815\n"
      "  morgagni serve --case cases/0815 --camera simulated:");
  mor::add_prepare_command(app);
  mor::add_serve_command(app);
  mor::add_record_command(app);
  mor::add_self_calibrate_command(app);
  mor::add_document_command(app);
  mor::add_evaluate_command(app);
  mor::add_pacs_command(app);
  mor::add_calibrate_command(app);
  mor::add_doctor_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return mor::kExitUsage;
  }
  return 0;
}
