// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/evaluation/internal/svg.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/xml_text.h"

namespace mor::internal {

Svg::Svg(double width, double height) : width_(width), height_(height) {
  rectangle({0.0, 0.0}, width, height, "#ffffff");
}

void Svg::line(SvgPoint from, SvgPoint to, std::string_view color, double width) {
  body_ += fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" "
      "stroke-width=\"{}\"/>\n",
      from.x,
      from.y,
      to.x,
      to.y,
      color,
      width);
}

void Svg::polyline(const std::vector<SvgPoint>& points,
                   std::string_view color,
                   double width,
                   std::string_view dash) {
  body_ += "<polyline points=\"";
  for (const auto& [x, y] : points) body_ += fmt::format("{:.1f},{:.1f} ", x, y);
  body_ += fmt::format("\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"", color, width);
  if (!dash.empty()) body_ += fmt::format(" stroke-dasharray=\"{}\"", dash);
  body_ += "/>\n";
}

void Svg::dot(SvgPoint at, double radius, std::string_view color, bool filled) {
  body_ += fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\" stroke=\"{}\" "
      "stroke-width=\"1.5\"/>\n",
      at.x,
      at.y,
      radius,
      filled ? color : "#ffffff",
      color);
}

void Svg::rectangle(SvgPoint corner, double width, double height, std::string_view color) {
  body_ += fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
      corner.x,
      corner.y,
      width,
      height,
      color);
}

void Svg::text(
    SvgPoint at, std::string_view words, std::string_view anchor, double size, bool bold) {
  body_ += fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\"{}>{}</text>\n",
      at.x,
      at.y,
      anchor,
      size,
      bold ? " font-weight=\"bold\"" : "",
      xml_text(words));
}

void Svg::upright_text(SvgPoint at, std::string_view words, double size) {
  body_ += fmt::format(
      "<text transform=\"translate({:.1f},{:.1f}) rotate(-90)\" text-anchor=\"middle\" "
      "font-size=\"{}\">{}</text>\n",
      at.x,
      at.y,
      size,
      xml_text(words));
}

std::string Svg::finish() const {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"Helvetica, Arial, sans-serif\" fill=\"#333333\">\n{2}</svg>\n",
      width_,
      height_,
      body_);
}

SvgAxis::SvgAxis(double least, double most, double from_px, double to_px, bool is_logarithmic)
    : least_(least),
      most_(most),
      from_px_(from_px),
      to_px_(to_px),
      is_logarithmic_(is_logarithmic) {}

double SvgAxis::px(double value) const {
  const double at = std::clamp(value, least_, most_);
  const double share = is_logarithmic_ ? std::log(at / least_) / std::log(most_ / least_)
                                       : (at - least_) / (most_ - least_);
  return std::lerp(from_px_, to_px_, share);
}

std::vector<double> SvgAxis::ticks() const {
  std::vector<double> ticks;
  if (is_logarithmic_) {
    for (double ten = std::pow(10.0, std::floor(std::log10(least_))); ten <= most_; ten *= 10.0) {
      for (const double part : {1.0, 2.0, 5.0}) {
        const double value = part * ten;
        if (value >= least_ * 0.999 && value <= most_ * 1.001) ticks.push_back(value);
      }
    }
    return ticks;
  }
  constexpr double kWanted = 5.0;
  const double rough = (most_ - least_) / kWanted;
  const double ten = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * ten;
  for (const double part : {5.0, 2.0, 1.0}) {
    if (part * ten >= rough) step = part * ten;
  }
  for (double value = std::ceil(least_ / step) * step; value <= most_ + 1e-9; value += step) {
    ticks.push_back(value);
  }
  return ticks;
}

}  // namespace mor::internal
