// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/internal/color_difference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mor::internal {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

double linear(double value) {
  const double v = std::clamp(value / 255.0, 0.0, 1.0);
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double lab_curve(double t) {
  constexpr double kKnee = 6.0 / 29.0;
  return t > kKnee * kKnee * kKnee ? std::cbrt(t) : t / (3.0 * kKnee * kKnee) + 4.0 / 29.0;
}

/// In [0, 360).
double hue_deg(double a, double b) {
  if (a == 0.0 && b == 0.0) return 0.0;
  const double hue = std::atan2(b, a) / kDegree;
  return hue < 0.0 ? hue + 360.0 : hue;
}

double pow7_share(double chroma) {
  const double p = std::pow(chroma, 7.0);
  return std::sqrt(p / (p + std::pow(25.0, 7.0)));
}

double mean_hue_deg(double h1, double h2, bool has_no_hue) {
  if (has_no_hue) return h1 + h2;
  if (std::abs(h1 - h2) <= 180.0) return 0.5 * (h1 + h2);
  return h1 + h2 < 360.0 ? 0.5 * (h1 + h2 + 360.0) : 0.5 * (h1 + h2 - 360.0);
}

}  // namespace

Vector3d lab_from_srgb(const Vector3d& rgb) {
  const double r = linear(rgb.x());
  const double g = linear(rgb.y());
  const double b = linear(rgb.z());
  const double x = (0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047;
  const double y = 0.2126729 * r + 0.7151522 * g + 0.0721750 * b;
  const double z = (0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883;
  return {116.0 * lab_curve(y) - 16.0,
          500.0 * (lab_curve(x) - lab_curve(y)),
          200.0 * (lab_curve(y) - lab_curve(z))};
}

double ciede2000(const Vector3d& lab_a, const Vector3d& lab_b) {
  const double c1 = std::hypot(lab_a.y(), lab_a.z());
  const double c2 = std::hypot(lab_b.y(), lab_b.z());
  const double g = 0.5 * (1.0 - pow7_share(0.5 * (c1 + c2)));
  const double a1 = (1.0 + g) * lab_a.y();
  const double a2 = (1.0 + g) * lab_b.y();
  const double cp1 = std::hypot(a1, lab_a.z());
  const double cp2 = std::hypot(a2, lab_b.z());
  const double h1 = hue_deg(a1, lab_a.z());
  const double h2 = hue_deg(a2, lab_b.z());
  const bool has_no_hue = cp1 * cp2 == 0.0;
  double dh = has_no_hue ? 0.0 : h2 - h1;
  if (dh > 180.0) dh -= 360.0;
  if (dh < -180.0) dh += 360.0;
  const double d_lightness = lab_b.x() - lab_a.x();
  const double d_chroma = cp2 - cp1;
  const double d_hue = 2.0 * std::sqrt(cp1 * cp2) * std::sin(0.5 * dh * kDegree);
  const double lightness = 0.5 * (lab_a.x() + lab_b.x());
  const double chroma = 0.5 * (cp1 + cp2);
  const double hue = mean_hue_deg(h1, h2, has_no_hue);
  const double t =
      1.0 - 0.17 * std::cos((hue - 30.0) * kDegree) + 0.24 * std::cos(2.0 * hue * kDegree) +
      0.32 * std::cos((3.0 * hue + 6.0) * kDegree) - 0.20 * std::cos((4.0 * hue - 63.0) * kDegree);
  const double off = (lightness - 50.0) * (lightness - 50.0);
  const double s_lightness = 1.0 + 0.015 * off / std::sqrt(20.0 + off);
  const double s_chroma = 1.0 + 0.045 * chroma;
  const double s_hue = 1.0 + 0.015 * chroma * t;
  const double turn = std::exp(-std::pow((hue - 275.0) / 25.0, 2.0));
  const double rotation = -2.0 * pow7_share(chroma) * std::sin(60.0 * turn * kDegree);
  const double l = d_lightness / s_lightness;
  const double c = d_chroma / s_chroma;
  const double h = d_hue / s_hue;
  return std::sqrt(std::max(0.0, l * l + c * c + h * h + rotation * c * h));
}

}  // namespace mor::internal
