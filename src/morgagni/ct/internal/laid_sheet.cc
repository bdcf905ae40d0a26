// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/laid_sheet.h"

#include <algorithm>
#include <cmath>

namespace mor::internal {
namespace {

/// A sheet is larger than an ear, seen from both sides.
constexpr double kLeastMm2 = 2500.0;
/// A thinner one is nowhere seen but blurred.
constexpr float kLeastMm = 1.5F;
constexpr float kLeastCosine = 0.7F;
/// Patches of an ear are smaller, or bend more within 6 mm: the mean cosine there.
constexpr double kLeastPatchMm2 = 300.0;
constexpr float kLeastSmooth = 0.88F;
/// Where it lies on skin its HU differ from where it is lifted by up to this.
constexpr float kFirstHu = 25.0F;
constexpr float kStrictestHu = 12.0F;
constexpr float kStepHu = 4.0F;
constexpr float kLastStartHu = 20.0F;  ///< By then noise does not make it grow any more.
constexpr float kLoosestHu = 36.0F;
/// What hardly touches the body is told from it by other means (body_mask()).
constexpr double kLeastLaid = 0.25;
/// By so much its area may grow from step to step; at first, out of the noise, by more.
constexpr double kMostGrowth = 1.08;
constexpr double kMostFirstGrowth = 1.12;

float middle_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class Search {
 public:
  Search(const SkinProfiles& profiles,
         const std::vector<SurfacePlace>& places,
         const LiftedSheet& sheet)
      : profiles_(profiles), places_(places), sheet_(sheet), wanted_hu_(sheet.hu) {
    last_ = std::max(
        static_cast<std::size_t>(kFirst),
        static_cast<std::size_t>((sheet.thick_mm - SkinProfile::kStepMm) / SkinProfile::kStepMm));
    last_ = std::min(last_, sheet.hu.size() - 1);
    // Beneath its lifted places is air, which its inner half shares voxels with.
    for (std::size_t step = sheet.num_outer(); step <= last_; ++step)
      wanted_hu_[step] = std::max(wanted_hu_[step], wanted_hu_[step - 1]);
    beside_.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      for (const std::size_t k : profiles.beside(i))
        if (goes_on(i, k)) beside_[i].push_back(k);
    find_smooth_patches();
  }

  std::vector<std::size_t> run() {
    if (smooth_.empty()) return {};
    learn_from(found(kFirstHu));
    auto all = found(kStrictestHu);
    double laid_mm2 = laid_area_mm2(all);
    bool is_told = false;
    for (float most_hu = kStrictestHu + kStepHu; most_hu <= kLoosestHu; most_hu += kStepHu) {
      auto more = found(most_hu);
      const double more_mm2 = laid_area_mm2(more);
      const bool is_steady = more_mm2 <= (is_told ? kMostGrowth : kMostFirstGrowth) * laid_mm2;
      if (!is_steady && (is_told || most_hu >= kLastStartHu)) break;
      is_told = is_steady;
      all = std::move(more);
      laid_mm2 = more_mm2;
    }
    if (!is_told || looks_like_skin(all) || laid_mm2 < kLeastLaid * profiles_.area_mm2(smooth_))
      return {};
    return all;
  }

 private:
  static constexpr int kFirst = 2;  ///< Step: at the surface the edge's blur tells nothing.

  [[nodiscard]] float facing(std::size_t a, std::size_t b) const {
    return profiles_.all()[a].inwards.dot(profiles_.all()[b].inwards);
  }

  [[nodiscard]] double laid_area_mm2(const std::vector<std::size_t>& places) const {
    double sum = 0.0;
    for (const std::size_t i : places)
      if (places_[i].lifted_mm == 0.0F) sum += profiles_.all()[i].area_mm2;
    return sum;
  }

  /// Whether skin elsewhere looks as the sheet does.
  [[nodiscard]] bool looks_like_skin(const std::vector<std::size_t>& taken) const {
    constexpr double kMostAlike = 0.2;
    constexpr float kAlikeHu = 16.0F;
    constexpr double kMostOfAll = 0.6;  // Or nothing is left to compare it with.
    std::vector<char> is_taken(places_.size());
    for (const std::size_t i : taken) is_taken[i] = 1;
    double all_mm2 = 0.0;
    double alike_mm2 = 0.0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (is_taken[i] != 0 || places_[i].lifted_mm > 0.0F) continue;
      const double area_mm2 = profiles_.all()[i].area_mm2;
      all_mm2 += area_mm2;
      if (off_hu(i, last_) <= kAlikeHu) alike_mm2 += area_mm2;
    }
    return alike_mm2 > kMostAlike * all_mm2 ||
           laid_area_mm2(taken) > kMostOfAll / (1.0 - kMostOfAll) * all_mm2;
  }

  /// By how much a place differs from the sheet, down to a step. In its inner half it may be
  /// anything between what it is over skin and over air: over fat, over a narrow gap.
  [[nodiscard]] float off_hu(std::size_t i, std::size_t last) const {
    float most = 0.0F;
    for (std::size_t step = kFirst; step <= last; ++step) {
      const float hu = profiles_.all()[i].at(static_cast<int>(step));
      const float least = step < sheet_.num_outer() ? wanted_hu_[step]
                                                    : std::min(wanted_hu_[step], sheet_.hu[step]);
      most = std::max({most, hu - wanted_hu_[step], least - hu});
    }
    return most;
  }

  /// Whether the surface at one place leads to the other: not to the far side of an ear.
  [[nodiscard]] bool goes_on(std::size_t from, std::size_t to) const {
    constexpr float kMostOffMm = 1.7F;
    const auto& start = profiles_.all()[from];
    const auto& end = profiles_.all()[to];
    return facing(from, to) >= kLeastCosine &&
           std::abs((end.place_mm - start.place_mm).dot(start.inwards)) <= kMostOffMm;
  }

  /// The mean cosine around: 1 where the surface is flat.
  [[nodiscard]] float smoothness(std::size_t i) const {
    float sum = 0.0F;
    float num = 0.0F;
    for (const std::size_t beside : profiles_.beside(i)) {
      for (const std::size_t k : profiles_.beside(beside)) {
        const float cosine = facing(i, k);
        if (cosine <= 0.0F) continue;  // The other side.
        sum += cosine;
        num += 1.0F;
      }
    }
    return num > 0.0F ? sum / num : 0.0F;
  }

  void find_smooth_patches() {
    std::vector<char> seen(places_.size(), 1);
    for (const std::size_t i : sheet_.places) seen[i] = 0;
    for (const std::size_t start : sheet_.places) {
      if (seen[start] != 0) continue;
      const auto patch = profiles_.region(
          start, seen, [&](std::size_t from, std::size_t to) { return goes_on(from, to); });
      std::vector<float> smooth(patch.size());
      std::transform(
          patch.begin(), patch.end(), smooth.begin(), [&](std::size_t i) { return smoothness(i); });
      if (profiles_.area_mm2(patch) >= kLeastPatchMm2 && middle_of(smooth) >= kLeastSmooth)
        smooth_.insert(smooth_.end(), patch.begin(), patch.end());
    }
  }

  [[nodiscard]] bool is_like(std::size_t i, float most_hu) const {
    if (profiles_.all()[i].area_mm2 <= 0.0F) return false;
    if (places_[i].lifted_mm > 0.0F) return is_lifted_alike(i);
    return off_hu(i, last_) <= most_hu;
  }

  [[nodiscard]] bool is_lifted_alike(std::size_t i) const {
    constexpr float kMostMm = 1.0F;
    constexpr float kMostHu = 40.0F;
    return std::abs(places_[i].lifted_mm - sheet_.thick_mm) <= kMostMm &&
           std::abs(places_[i].most_hu - sheet_.most_hu) <= kMostHu;
  }

  /// What the places are when `is_in` says what they are by themselves: what most around say.
  [[nodiscard]] std::vector<char> by_majority(const std::vector<char>& is_in,
                                              bool is_filling) const {
    constexpr float kMostHu = 75.0F;  // Where it comes down, blurred with the skin and the gap.
    auto result = is_in;
    for (std::size_t i = 0; i < is_in.size(); ++i) {
      if ((is_in[i] != 0) == is_filling || profiles_.all()[i].area_mm2 <= 0.0F) continue;
      std::size_t num = is_in[i] != 0 ? 1 : 0;
      for (const std::size_t k : beside_[i]) num += is_in[k] != 0 ? 1 : 0;
      const bool most = 2 * num > beside_[i].size() + 1;
      result[i] = most && (!is_filling || off_hu(i, sheet_.num_outer() - 1) <= kMostHu) ? 1 : 0;
    }
    return result;
  }

  [[nodiscard]] std::vector<std::size_t> found(float most_hu) const {
    constexpr int kMostFills = 10;
    std::vector<char> is_in(places_.size());
    for (std::size_t i = 0; i < places_.size(); ++i) is_in[i] = is_like(i, most_hu) ? 1 : 0;
    is_in = by_majority(is_in, false);
    for (int fill = 0; fill < kMostFills; ++fill) is_in = by_majority(is_in, true);
    return joined(is_in);
  }

  [[nodiscard]] std::vector<std::size_t> joined(std::vector<char>& is_in) const {
    auto reached = smooth_;
    for (const std::size_t i : reached) is_in[i] = 0;
    // Where a sheet comes down to the skin it bends, too.
    for (const std::size_t i : around(smooth_)) {
      if (is_in[i] == 0) continue;
      is_in[i] = 0;
      reached.push_back(i);
    }
    for (std::size_t next = smooth_.size(); next < reached.size(); ++next) {
      for (const std::size_t k : beside_[reached[next]]) {
        if (is_in[k] == 0) continue;
        is_in[k] = 0;
        reached.push_back(k);
      }
    }
    return reached;
  }

  /// Within some 9 mm of some places; not these.
  [[nodiscard]] std::vector<std::size_t> around(const std::vector<std::size_t>& places) const {
    const int kSteps = 3;
    std::vector<char> seen(places_.size());
    for (const std::size_t i : places) seen[i] = 1;
    std::vector<std::size_t> found;
    auto front = places;
    for (int step = 0; step < kSteps; ++step) {
      std::vector<std::size_t> next;
      for (const std::size_t i : front) {
        for (const std::size_t k : beside_[i]) {
          if (seen[k] != 0) continue;
          seen[k] = 1;
          next.push_back(k);
        }
      }
      found.insert(found.end(), next.begin(), next.end());
      front = std::move(next);
    }
    return found;
  }

  void learn_from(const std::vector<std::size_t>& found) {
    for (std::size_t step = kFirst; step <= last_; ++step) {
      std::vector<float> hu;
      for (const std::size_t i : found)
        if (places_[i].lifted_mm == 0.0F)
          hu.push_back(profiles_.all()[i].at(static_cast<int>(step)));
      if (hu.empty()) return;
      wanted_hu_[step] = middle_of(hu);
    }
  }

  const SkinProfiles& profiles_;
  const std::vector<SurfacePlace>& places_;
  const LiftedSheet& sheet_;
  std::vector<std::size_t> smooth_;               ///< Of the sheet's places: it may touch an ear.
  std::vector<float> wanted_hu_;                  ///< Where it lies on the skin, step by step.
  std::size_t last_ = 0;                          ///< Step that still lies in the sheet.
  std::vector<std::vector<std::size_t>> beside_;  ///< That face alike.
};

}  // namespace

std::size_t LiftedSheet::num_outer() const {
  return 1 + static_cast<std::size_t>((0.5 * thick_mm + 0.25) / SkinProfile::kStepMm);
}

std::vector<std::size_t> sheet_places(const SkinProfiles& profiles,
                                      const std::vector<SurfacePlace>& places,
                                      const LiftedSheet& sheet) {
  if (!sheet.is_even || sheet.area_mm2 < kLeastMm2 || sheet.thick_mm < kLeastMm) return {};
  return Search(profiles, places, sheet).run();
}

}  // namespace mor::internal
