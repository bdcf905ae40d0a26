// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/ct/internal/thin_layers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "morgagni/ct/internal/foam_cover.h"
#include "morgagni/ct/internal/laid_sheet.h"
#include "morgagni/ct/internal/lifted_sheet.h"

namespace mor::internal {
namespace {

constexpr auto kEdgeHu = static_cast<float>(SkinProfile::kEdgeHu);
/// What is thicker is no layer.
constexpr float kThinMm = 5.0F;
/// Smaller pieces are noise, or belong to an ear.
constexpr double kLeastMm2 = 400.0;
/// Between these a layer looks like skin.
constexpr float kLightHu = -95.0F;
constexpr float kDenseHu = 150.0F;
/// Foam of a mattress or a headrest, and air.
constexpr float kMostFoamHu = -760.0F;
constexpr float kLeastFoamHu = -960.0F;
/// Of a lifted sheet so much more is taken: nothing of it is to hang on to an ear.
constexpr float kAllOfItMm = 0.4F;

bool is_like_skin(float hu) {
  return hu > kLightHu && hu < kDenseHu;
}

bool is_foam(float hu) {
  return hu > kLeastFoamHu && hu < kMostFoamHu;
}

float depth_mm(const SkinProfile& profile, int step, float hu) {
  const float before_hu = profile.at(step - 1);
  const float share = (hu - before_hu) / (profile.at(step) - before_hu);
  return static_cast<float>(SkinProfile::kStepMm) * (static_cast<float>(step - 1) + share);
}

void see_lifted(const SkinProfile& profile, SurfacePlace& place) {
  constexpr int kLast = static_cast<int>(kThinMm / SkinProfile::kStepMm);
  place.most_hu = profile.at(0);
  for (int step = 1; step <= kLast; ++step) {
    if (profile.at(step) < std::min(kEdgeHu, profile.at(step - 1))) {
      place.lifted_mm = std::max(0.1F, depth_mm(profile, step, kEdgeHu));
      return;
    }
    place.most_hu = std::max(place.most_hu, profile.at(step));
  }
}

/// The second of two steps upwards, beneath a plateau of cloth.
struct SecondStep {
  int last = 0;
  float skin_hu = 0.0F;
  bool is_clear = false;
};

/// @param first  On the plateau. The step is steeper than the plateau and ends at skin: where bone
///               lies close beneath the skin the HU go on rising.
SecondStep second_step(const SkinProfile& profile, int first) {
  constexpr int kReach = 5;
  constexpr float kLeastSteep = 30.0F;
  constexpr float kMostSkinHu = 150.0F;
  constexpr float kLeastSkinHu = -60.0F;
  constexpr float kLeastRiseHu = 70.0F;
  const float cover_hu = profile.at(first);
  const float plateau =
      std::max(0.0F, std::min(profile.at(first + 1) - cover_hu, cover_hu - profile.at(first - 1)));
  SecondStep step = {first, cover_hu};
  float steepest = 0.0F;
  bool ends = false;
  for (int k = first + 1; k <= first + kReach && !ends; ++k) {
    const float rise = profile.at(k) - step.skin_hu;
    steepest = std::max(steepest, rise);
    ends = steepest > 25.0F && rise < 0.4F * steepest;
    if (rise < 0.0F) break;
    step.skin_hu = profile.at(k);
    step.last = k;
  }
  step.is_clear = ends && step.skin_hu <= kMostSkinHu &&
                  step.skin_hu >= std::max(cover_hu + kLeastRiseHu, kLeastSkinHu) &&
                  steepest >= std::max(kLeastSteep, 1.4F * plateau + 10.0F);
  return step;
}

void see_light(const SkinProfile& profile, SurfacePlace& place) {
  constexpr float kLightestHu = -420.0F;
  constexpr int kLast = 6;
  constexpr float kSkinShare = 0.67F;  // As much of the way as -300 HU are from air to skin.
  for (int first = 1; first <= kLast; ++first) {
    const float cover_hu = profile.at(first);
    if (cover_hu > kLightHu) return;
    if (cover_hu < kLightestHu) continue;
    const auto step = second_step(profile, first);
    if (!step.is_clear) continue;
    const float edge_hu = cover_hu + kSkinShare * (step.skin_hu - cover_hu);
    for (int k = first + 1; k <= step.last && place.light_mm == 0.0F; ++k)
      if (profile.at(k) >= edge_hu) place.light_mm = depth_mm(profile, k, edge_hu);
    return;
  }
}

float share_of(std::vector<float> values, double share) {
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

class Search {
 public:
  Search(const Volume& volume, const SkinProfiles& profiles)
      : volume_(volume), profiles_(profiles), places_(profiles.all().size()) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto& profile = profiles.all()[i];
      if (profile.area_mm2 <= 0.0F) continue;
      see_lifted(profile, places_[i]);
      if (places_[i].lifted_mm == 0.0F) see_light(profile, places_[i]);
      places_[i].outside_hu = (profile.hu[0] + profile.hu[1] + profile.hu[2]) / 3.0F;
    }
    found_.thick_mm.resize(places_.size());
    found_.is_lifted.resize(places_.size());
    found_.is_sheet.resize(places_.size());
    found_.unknown_mm.resize(places_.size());
  }

  ThinLayers run(const std::vector<Eigen::Vector3f>& take_off_mm) {
    find_lifted();
    find_light();
    for (const LiftedSheet& sheet : sheets_)
      if (!is_skin_like(sheet)) follow(sheet);
    take_cover_of_foam();
    fill_gaps();
    for (const LiftedSheet& sheet : sheets_) doubt_around(sheet.places, sheet.thick_mm);
    for (const LiftedSheet& sheet : like_skin_) doubt_around(sheet.places, sheet.thick_mm);
    for (const auto& place_mm : take_off_mm)
      if (!take_stretch_at(place_mm)) found_.not_found_mm.push_back(place_mm);
    return std::move(found_);
  }

 private:
  template <class ValueOf>
  [[nodiscard]] static float share(const std::vector<std::size_t>& places,
                                   double share,
                                   const ValueOf& value_of) {
    std::vector<float> values;
    for (const std::size_t i : places) values.push_back(value_of(i));
    return share_of(std::move(values), share);
  }

  void find_lifted() {
    std::vector<char> seen(places_.size());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (seen[i] != 0 || places_[i].lifted_mm == 0.0F) continue;
      auto places = profiles_.region(i, seen, [&](std::size_t from, std::size_t to) {
        const float most_hu = std::max(30.0F, 0.2F * places_[from].most_hu);
        return places_[to].lifted_mm > 0.0F &&
               std::abs(places_[to].lifted_mm - places_[from].lifted_mm) < 0.6F &&
               std::abs(places_[to].most_hu - places_[from].most_hu) < most_hu;
      });
      if (profiles_.area_mm2(places) >= kLeastMm2) judge(std::move(places));
    }
  }

  /// Ears are 3 to 4.5 mm thick and of 60 to 160 HU, from place to place.
  void judge(std::vector<std::size_t> places) {
    constexpr float kMostUnevenMm = 0.9F;
    constexpr float kMostUnevenHu = 40.0F;
    constexpr float kDenserThanEarsHu = 180.0F;
    constexpr float kThinnerThanEarsMm = 2.9F;
    constexpr float kLighterThanEarsHu = -60.0F;
    const auto thick = [&](std::size_t i) { return places_[i].lifted_mm; };
    const auto most = [&](std::size_t i) { return places_[i].most_hu; };
    const float least_hu = share(places, 0.1, most);
    const float most_hu = share(places, 0.9, most);
    const float most_mm = share(places, 0.9, thick);
    const bool is_even = most_mm - share(places, 0.1, thick) <= kMostUnevenMm &&
                         (most_hu - least_hu <= kMostUnevenHu || least_hu >= kDenserThanEarsHu);
    if (!is_even && most_mm > kThinnerThanEarsMm && most_hu > kLighterThanEarsHu) return;
    LiftedSheet sheet = {share(places, 0.5, thick),
                         share(places, 0.5, most),
                         share(places, 0.5, [&](std::size_t i) { return places_[i].outside_hu; }),
                         is_even,
                         profiles_.area_mm2(places),
                         {},
                         {}};
    const int num = 1 + static_cast<int>(sheet.thick_mm / static_cast<float>(SkinProfile::kStepMm));
    for (int step = 0; step < num; ++step)
      sheet.hu.push_back(
          share(places, 0.5, [&](std::size_t i) { return profiles_.all()[i].at(step); }));
    sheet.places = std::move(places);
    if (is_skin_like(sheet)) {
      auto told = sheet_places(profiles_, places_, sheet);
      if (told.empty()) {
        like_skin_.push_back(std::move(sheet));
        return;
      }
      sheet.places = std::move(told);
    }
    for (const std::size_t k : sheet.places) take(k, sheet, true);
    sheets_.push_back(std::move(sheet));
  }

  /// As a tube's wall is.
  [[nodiscard]] static bool is_skin_like(const LiftedSheet& sheet) {
    return is_like_skin(sheet.most_hu) && !is_foam(sheet.outside_hu);
  }

  void find_light() {
    constexpr float kLeastMm = 0.8F;
    std::vector<char> seen(places_.size());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (seen[i] != 0 || places_[i].light_mm < kLeastMm) continue;
      const auto places = profiles_.region(
          i, seen, [&](std::size_t, std::size_t to) { return places_[to].light_mm >= kLeastMm; });
      if (profiles_.area_mm2(places) < kLeastMm2) continue;
      for (const std::size_t k : places) found_.thick_mm[k] = places_[k].light_mm;
    }
  }

  /// From where a sheet is lifted to where it lies on the skin.
  void follow(const LiftedSheet& sheet) {
    std::vector<char> seen(places_.size());
    for (const std::size_t i : sheet.places) seen[i] = 1;
    for (const std::size_t start : sheet.places) {
      for (const std::size_t k :
           profiles_.region(start, seen, [&](std::size_t from, std::size_t to) {
             return faces_alike(from, to) && goes_on(to, sheet);
           })) {
        if (found_.thick_mm[k] == 0.0F)
          take(k, sheet, is_about(places_[k].lifted_mm, sheet.thick_mm, 0.7F));
      }
    }
  }

  /// All that one foam lies over has one cover, whose thickness its largest sheet shows best. Where
  /// it is lighter than skin it is seen by itself.
  void take_cover_of_foam() {
    constexpr float kLightestHu = -140.0F;  // Thin, and blurred.
    const LiftedSheet* largest = nullptr;
    for (const LiftedSheet& sheet : sheets_)
      if (is_foam(sheet.outside_hu) && (largest == nullptr || sheet.area_mm2 > largest->area_mm2))
        largest = &sheet;
    if (largest == nullptr || largest->most_hu < kLightestHu || largest->most_hu > kDenseHu) return;
    FoamCover cover = foam_cover(volume_, profiles_, *largest);
    for (const std::size_t i : cover.places)
      if (found_.thick_mm[i] == 0.0F || found_.is_sheet[i] != 0) take_cover(i, *largest);
    found_.foam = std::move(cover.foam);
  }

  void take_cover(std::size_t i, const LiftedSheet& sheet) {
    // Between foam and air it is blurred from both sides, and seems thinner than on the skin.
    constexpr float kBlurMm = 0.25F;
    found_.is_sheet[i] = 1;
    found_.is_lifted[i] = 0;
    found_.thick_mm[i] = sheet.thick_mm + kBlurMm;
    if (is_lifted_alone(i, sheet)) found_.thick_mm[i] += kAllOfItMm;
  }

  void take(std::size_t i, const LiftedSheet& sheet, bool is_lifted) {
    found_.is_sheet[i] = 1;
    found_.thick_mm[i] = sheet.thick_mm;
    if (is_skin_like(sheet)) {
      if (places_[i].lifted_mm > 0.0F) found_.thick_mm[i] += kAllOfItMm;
    } else if (is_lifted) {
      found_.is_lifted[i] = 1;
      // Where it comes down to the skin some of the skin seems to be sheet.
      found_.thick_mm[i] = std::min(places_[i].lifted_mm, sheet.thick_mm);
    }
  }

  /// Nothing as thin as an ear beneath it, and no skin.
  [[nodiscard]] bool is_lifted_alone(std::size_t i, const LiftedSheet& sheet) const {
    constexpr float kSomethingBeneathMm = 1.5F;
    return places_[i].lifted_mm > 0.0F &&
           places_[i].lifted_mm < sheet.thick_mm + kSomethingBeneathMm;
  }

  static bool is_about(float value, float wanted, float most) {
    return std::abs(value - wanted) <= most;
  }

  /// In the wedge where a sheet comes down, places face the wedge.
  [[nodiscard]] bool faces_alike(std::size_t a, std::size_t b) const {
    constexpr float kLeastCosine = 0.7F;
    return profiles_.all()[a].inwards.dot(profiles_.all()[b].inwards) >= kLeastCosine;
  }

  [[nodiscard]] bool goes_on(std::size_t i, const LiftedSheet& sheet) const {
    const SurfacePlace& place = places_[i];
    if (is_lifted_alone(i, sheet))
      return is_about(place.lifted_mm, sheet.thick_mm, 0.7F) &&
             is_about(
                 place.most_hu, sheet.most_hu, std::max(40.0F, 0.25F * std::abs(sheet.most_hu)));
    if (is_foam(sheet.outside_hu)) return is_about(place.outside_hu, sheet.outside_hu, 30.0F);
    return looks_the_same(profiles_.all()[i], sheet);
  }

  [[nodiscard]] static float tolerance_hu(const LiftedSheet& sheet) {
    return std::max(25.0F, 0.2F * std::abs(sheet.most_hu));
  }

  [[nodiscard]] static bool looks_the_same(const SkinProfile& profile, const LiftedSheet& sheet) {
    const std::size_t num = std::min(sheet.num_outer(), sheet.hu.size());
    for (std::size_t step = 1; step < num; ++step) {
      const float most_hu = (step == 1 ? 2.0F : 1.0F) * tolerance_hu(sheet);
      if (!is_about(profile.at(static_cast<int>(step)), sheet.hu[step], most_hu)) return false;
    }
    return true;
  }

  /// Where most neighbours are light layers, noise and bends hide that this place is one, too.
  void fill_gaps() {
    constexpr float kCoverHu = -60.0F;
    constexpr int kOneMm = 2;
    const auto is_cover = [&](std::size_t i) { return profiles_.all()[i].at(kOneMm) < kCoverHu; };
    const auto before = found_.thick_mm;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (before[i] != 0.0F || profiles_.all()[i].area_mm2 <= 0.0F || !is_cover(i)) continue;
      const auto near = profiles_.beside(i);
      std::vector<float> thick;
      for (const std::size_t k : near)
        if (before[k] > 0.0F && is_cover(k)) thick.push_back(before[k]);
      if (2 * thick.size() > near.size()) found_.thick_mm[i] = share_of(thick, 0.5);
    }
  }

  /// Beside a sheet, where it comes down and is not seen any more.
  void doubt_around(const std::vector<std::size_t>& places, float thick_mm) {
    constexpr int kSteps = 5;
    auto front = places;
    for (int step = 0; step < kSteps; ++step) {
      std::vector<std::size_t> next;
      for (const std::size_t i : front) {
        for (const std::size_t k : profiles_.beside(i)) {
          if (found_.unknown_mm[k] > 0.0F || found_.thick_mm[k] > 0.0F ||
              places_[k].lifted_mm > 0.0F)
            continue;
          found_.unknown_mm[k] = thick_mm;
          next.push_back(k);
        }
      }
      front = std::move(next);
    }
  }

  /// As somebody asked for. @return Whether there was any.
  bool take_stretch_at(const Eigen::Vector3f& place_mm) {
    const auto start = nearest_unknown(place_mm);
    if (!start) return is_taken_at(place_mm);
    std::vector<char> seen(places_.size());
    const auto stretch = profiles_.region(
        *start, seen, [&](std::size_t, std::size_t to) { return found_.unknown_mm[to] > 0.0F; });
    for (const LiftedSheet& sheet : like_skin_) {
      const bool touches =
          std::any_of(sheet.places.begin(), sheet.places.end(), [&](std::size_t i) {
            const auto near = profiles_.beside(i);
            return std::any_of(
                near.begin(), near.end(), [&](std::size_t k) { return seen[k] != 0; });
          });
      if (!touches) continue;
      for (const std::size_t i : sheet.places) take(i, sheet, true);
    }
    const float thick_mm = found_.unknown_mm[*start];
    for (const std::size_t i : stretch) {
      found_.is_sheet[i] = 1;
      found_.thick_mm[i] = found_.unknown_mm[i];
      found_.unknown_mm[i] = 0.0F;
    }
    found_.asked.insert(found_.asked.end(), stretch.begin(), stretch.end());
    doubt_around(stretch, thick_mm);  // It may go on: they can ask again.
    return true;
  }

  /// With a place before it.
  [[nodiscard]] bool is_taken_at(const Eigen::Vector3f& place_mm) const {
    return std::any_of(found_.asked.begin(), found_.asked.end(), [&](std::size_t i) {
      return off_mm(i, place_mm) <= kMostOffMm;
    });
  }

  [[nodiscard]] float off_mm(std::size_t i, const Eigen::Vector3f& place_mm) const {
    return (profiles_.all()[i].place_mm - place_mm).norm();
  }

  [[nodiscard]] std::optional<std::size_t> nearest_unknown(const Eigen::Vector3f& place_mm) const {
    std::optional<std::size_t> nearest;
    float least = kMostOffMm;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const float off = off_mm(i, place_mm);
      if (found_.unknown_mm[i] <= 0.0F || off > least) continue;
      least = off;
      nearest = i;
    }
    return nearest;
  }

  static constexpr float kMostOffMm = 6.0F;  ///< Of what is asked for: two cells.

  const Volume& volume_;
  const SkinProfiles& profiles_;
  std::vector<SurfacePlace> places_;
  std::vector<LiftedSheet> sheets_;
  std::vector<LiftedSheet> like_skin_;  ///< That are left where they are.
  ThinLayers found_;
};

}  // namespace

ThinLayers thin_layers(const Volume& volume,
                       const SkinProfiles& profiles,
                       const std::vector<Eigen::Vector3f>& take_off_mm) {
  return Search(volume, profiles).run(take_off_mm);
}

}  // namespace mor::internal
