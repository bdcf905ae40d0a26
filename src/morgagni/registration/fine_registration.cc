// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/fine_registration.h"

#include <array>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/registration/internal/field_registration.h"
#include "morgagni/registration/internal/icp_registration.h"

namespace mor {
namespace {

constexpr std::array<std::pair<RegistrationMethod, std::string_view>, 5> kMethodNames = {{
    {RegistrationMethod::kIcp, "icp"},
    {RegistrationMethod::kTrimmedIcp, "trimmed-icp"},
    {RegistrationMethod::kAnisotropicIcp, "anisotropic-icp"},
    {RegistrationMethod::kTrimmedAnisotropicIcp, "trimmed-anisotropic-icp"},
    {RegistrationMethod::kField, "field"},
}};

}  // namespace

std::optional<RegistrationMethod> parse_registration_method(std::string_view name) {
  for (const auto& [method, method_name] : kMethodNames) {
    if (name == method_name) return method;
  }
  return std::nullopt;
}

std::string_view to_string(RegistrationMethod method) {
  for (const auto& [named, name] : kMethodNames) {
    if (named == method) return name;
  }
  return "unknown";
}

Result<void> RegistrationOptions::check() const {
  if (max_iterations < 1) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("max_iterations must be >= 1, got {}", max_iterations));
  }
  if (!(convergence_threshold >= 0.0) || !std::isfinite(convergence_threshold)) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("convergence_threshold must be >= 0, got {}", convergence_threshold));
  }
  if (!(overlap > 0.0 && overlap <= 1.0)) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("overlap must be in (0, 1], got {}", overlap));
  }
  return {};
}

Result<std::unique_ptr<FineRegistration>> make_fine_registration(
    std::shared_ptr<const FixedSurface> fixed, const RegistrationOptions& options) {
  MOR_CHECK(options.check());
  if (!fixed || fixed->mesh.vertices.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "registration needs a CT skin, but the fixed surface is empty");
  }
  if (options.method != RegistrationMethod::kField) {
    return internal::make_icp_registration(fixed->mesh, options);
  }
  if (options.device != "cpu") {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "the method \"field\" runs on the CPU, not on the device \"{}\"; the ICP methods "
            "run on OpenCL devices",
            options.device));
  }
  if (fixed->field.empty()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the method \"field\" needs the skin's distance field: prepare the case");
  }
  return std::make_unique<internal::FieldRegistration>(std::move(fixed), options);
}

}  // namespace mor
