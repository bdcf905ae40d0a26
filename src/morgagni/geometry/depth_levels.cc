// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/geometry/depth_levels.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

namespace mor {
namespace {

/// Pictures without steps after which none are expected any more.
constexpr int kMostPictures = 30;
/// Depths that are looked at: nearer, the steps are finer than a millimetre.
constexpr int kNearestMm = 600;
constexpr int kFarthestMm = 2500;
/// A value that occurs less often may be no reading's but an error.
constexpr int kLeastCount = 3;
/// Steps are 1 / K; a Kinect's K is 348,000 mm.
constexpr double kLeastK = 150e3;
constexpr double kMostK = 800e3;
/// Values whose steps are this far apart tell of them, if there are as many. Of values that have
/// nothing to do with steps one in `kTellingStepMm` would be on a step by chance.
constexpr double kTellingStepMm = 1.3;
constexpr std::size_t kLeastTelling = 60;
/// No depths nearer than this are taken back to their steps: a millimetre holds many.
constexpr int kFinestMm = 200;

/// Each fit puts the values on steps by the one before.
constexpr int kFits = 4;

/// 1 / depth = step i + offset, in 1/mm.
struct Steps {
  double step = 0.0;
  double offset = 0.0;

  [[nodiscard]] double index_of(double mm) const { return (1.0 / mm - offset) / step; }
  [[nodiscard]] double mm_of(double index) const { return 1.0 / (step * index + offset); }
  [[nodiscard]] double distance_at(double mm) const { return mm * mm * step; }
};

std::vector<double> values_of(ImageView<const std::uint16_t> depth_mm) {
  std::vector<int> counts(kFarthestMm + 1, 0);
  for (int y = 0; y < depth_mm.height(); ++y) {
    const std::uint16_t* row = depth_mm.row(y);
    for (int x = 0; x < depth_mm.width(); ++x) {
      ++counts[std::min<std::size_t>(row[x], kFarthestMm)];
    }
  }
  std::vector<double> values;
  for (int mm = kNearestMm; mm < kFarthestMm; ++mm) {
    if (counts[static_cast<std::size_t>(mm)] >= kLeastCount) values.push_back(mm);
  }
  return values;
}

/// The K whose steps the values follow best, by the sum of their phases.
Steps strongest_steps(const std::vector<double>& values) {
  constexpr double kPerK = 2.0 * std::numbers::pi;
  // Between neighbours the phase at either end of the depths changes by a quarter turn at most.
  constexpr double kGrowth = 0.25 / (1.0 / kNearestMm - 1.0 / kFarthestMm);
  std::vector<std::complex<double>> phases;
  std::vector<std::complex<double>> turns;
  for (const double mm : values) {
    phases.push_back(std::polar(1.0, kPerK * kLeastK / mm));
    turns.push_back(std::polar(1.0, kPerK * kGrowth / mm));
  }
  Steps best;
  double strongest = 0.0;
  for (double k = kLeastK; k < kMostK; k += kGrowth) {
    double real = 0.0;
    double imaginary = 0.0;
    for (std::size_t i = 0; i < phases.size(); ++i) {
      real += phases[i].real();
      imaginary += phases[i].imag();
      const double next = phases[i].real() * turns[i].real() - phases[i].imag() * turns[i].imag();
      phases[i].imag(phases[i].real() * turns[i].imag() + phases[i].imag() * turns[i].real());
      phases[i].real(next);
    }
    const double strength = real * real + imaginary * imaginary;
    if (strength <= strongest) continue;
    strongest = strength;
    best.step = 1.0 / k;
    best.offset = std::atan2(imaginary, real) / kPerK / k;
  }
  return best;
}

/// Least squares over the depths, each on the step nearest to it.
Steps fitted(const std::vector<double>& values, const Steps& about) {
  double n = 0.0, sum_i = 0.0, sum_x = 0.0, sum_ii = 0.0, sum_ix = 0.0;
  const double first = std::round(about.index_of(values.front()));
  for (const double mm : values) {
    // Rounding moves 1 / mm by as much as 1 / mm^2 says.
    const double weight = mm * mm * mm * mm * 1e-12;
    const double i = std::round(about.index_of(mm)) - first;
    n += weight;
    sum_i += weight * i;
    sum_x += weight / mm;
    sum_ii += weight * i * i;
    sum_ix += weight * i / mm;
  }
  const double step = (n * sum_ix - sum_i * sum_x) / (n * sum_ii - sum_i * sum_i);
  return {step, (sum_x - step * sum_i) / n - step * first};
}

/// By how much, in 1/mm, the offset may vary so that a step lies within half a millimetre of every
/// value, and its middle.
struct Leeway {
  double width = 0.0;
  double offset = 0.0;
};

Leeway leeway(const std::vector<double>& values, const std::vector<double>& index, double step) {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < values.size(); ++i) {
    least = std::max(least, 1.0 / (values[i] + 0.5) - step * index[i]);
    most = std::min(most, 1.0 / (values[i] - 0.5) - step * index[i]);
  }
  return {most - least, 0.5 * (least + most)};
}

/// The steps that explain every value, with the most leeway; none where some value stays beside
/// them. The leeway is concave in the step, so a ternary search finds its maximum.
std::optional<Steps> explaining(const std::vector<double>& values, const Steps& about) {
  std::vector<double> index;
  for (const double mm : values) index.push_back(std::round(about.index_of(mm)));
  const double span = index.front() - index.back();
  double low = about.step - 0.5 * about.step / span;
  double high = about.step + 0.5 * about.step / span;
  for (int i = 0; i < 60; ++i) {
    const double third = (high - low) / 3.0;
    if (leeway(values, index, low + third).width < leeway(values, index, high - third).width) {
      low += third;
    } else {
      high -= third;
    }
  }
  const double step = 0.5 * (low + high);
  const Leeway found = leeway(values, index, step);
  if (!(found.width >= 0.0)) return std::nullopt;
  return Steps{step, found.offset};
}

/// Steps, and where in the millimetre above or below its value a depth lies: at the value's own
/// place where the sensor rounds, half a millimetre beyond it where it cuts the fraction off.
struct RoundedSteps {
  Steps steps;
  double beyond_mm = 0.0;
};

std::optional<RoundedSteps> find_steps(std::vector<double> values) {
  if (values.size() < kLeastTelling) return std::nullopt;
  const Steps strongest = strongest_steps(values);
  std::erase_if(values, [&](double mm) { return strongest.distance_at(mm) < kTellingStepMm; });
  if (values.size() < kLeastTelling) return std::nullopt;
  // Both may explain the values of a small range: then a sensor is taken to round.
  for (const double beyond_mm : {0.0, 0.5}) {
    auto depths = values;
    for (double& mm : depths) mm += beyond_mm;
    Steps steps = strongest;
    for (int i = 0; i < kFits; ++i) steps = fitted(depths, steps);
    if (const auto found = explaining(depths, steps)) return RoundedSteps{*found, beyond_mm};
  }
  return std::nullopt;
}

/// The mean of the steps that become `value`; that itself where there are none.
float level_mm(const RoundedSteps& rounded, int value) {
  const Steps& steps = rounded.steps;
  const double middle_mm = value + rounded.beyond_mm;
  const double first = std::ceil(steps.index_of(middle_mm + 0.5));
  const double last = std::floor(steps.index_of(middle_mm - 0.5));
  if (!(first <= last)) return static_cast<float>(middle_mm);
  return static_cast<float>(0.5 * (steps.mm_of(first) + steps.mm_of(last)));
}

}  // namespace

DepthLevels::DepthLevels() : mm_(std::numeric_limits<std::uint16_t>::max() + std::size_t{1}) {
  std::iota(mm_.begin(), mm_.end(), 0.0F);
}

void DepthLevels::learn(ImageView<const std::uint16_t> depth_mm) {
  if (has_steps_ || num_pictures_ == kMostPictures) return;
  ++num_pictures_;
  const auto steps = find_steps(values_of(depth_mm));
  if (!steps) return;
  has_steps_ = true;
  for (std::size_t i = kFinestMm; i < mm_.size(); ++i) {
    mm_[i] = level_mm(*steps, static_cast<int>(i));
  }
}

}  // namespace mor
