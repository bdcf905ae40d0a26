// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/report.h"

#include <algorithm>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/image_png.h"
#include "morgagni/core/version.h"
#include "morgagni/documentation/body_picture.h"
#include "morgagni/documentation/internal/pdf_writer.h"

namespace mor {
namespace {

using internal::PdfBox;
using internal::PdfStyle;
using internal::PdfWriter;

constexpr double kPictureDpi = 200.0;
constexpr double kGap = 14.0;  ///< Between pictures side by side.
const Eigen::Vector3d kPinColor(0.70, 0.12, 0.10);

const char* const kBoundWords =
    "An error bound says how far a place that was seen by the camera may lie from its true place "
    "in "
    "the CT: 95 % of such errors are expected to be smaller. It comes from the fit of the camera's "
    "depth to the CT's skin. It does not cover errors of the CT itself, a body that has changed or "
    "been moved out of shape since the CT, or a systematic error of the camera's depth that was "
    "not "
    "stated. Where no bound is given, none is known.";

const char* const kCoordinateWords =
    "Coordinates are those of the CT in millimetres: x to the body's left, y to its back, z to its "
    "head (DICOM LPS). A distance is straight; a distance over the skin is the shortest way along "
    "the CT's skin.";

std::string plus_minus(const std::optional<double>& bound_mm) {
  return bound_mm ? fmt::format("\xC2\xB1 {:.1f} mm (95 %)", *bound_mm)
                  : std::string("uncertainty not known");
}

std::string kind_words(FindingKind kind) {
  switch (kind) {
    case FindingKind::kPoint:
      return "place";
    case FindingKind::kDistance:
      return "distance";
    case FindingKind::kGeodesic:
      return "distance over the skin";
  }
  return "";
}

std::string size_words(std::uintmax_t num_bytes) {
  const auto bytes = static_cast<double>(num_bytes);
  if (bytes >= 1e6) return fmt::format("{:.1f} MB", bytes / 1e6);
  if (bytes >= 1e3) return fmt::format("{:.1f} kB", bytes / 1e3);
  return fmt::format("{} B", num_bytes);
}

/// 1, 2 or 5 times a power of ten, at most `most`.
double round_length(double most) {
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= most) return factor * power;
  }
  return power;
}

std::string texture_words(const Report& report) {
  const auto& texture = report.source.texture;
  if (!texture) return "none: the skin is shown in one plain colour, which is not the body's";
  std::vector<double> bounds_mm;
  for (const auto& frame : texture->frames) {
    if (frame.bound_mm) bounds_mm.push_back(*frame.bound_mm);
  }
  std::string words = fmt::format("{:.0f} % of the skin, from {} camera pictures; {} x {} px",
                                  100.0 * report.model.seen_share,
                                  texture->frames.size(),
                                  report.model.picture.width(),
                                  report.model.picture.height());
  if (!bounds_mm.empty()) {
    std::sort(bounds_mm.begin(), bounds_mm.end());
    words += fmt::format("; error bound of their places {:.1f} mm (median), {:.1f} mm (largest)",
                         bounds_mm[bounds_mm.size() / 2],
                         bounds_mm.back());
  }
  return words;
}

class Composer {
 public:
  Composer(const Report& report, const std::vector<BodyPicture>& views, int num_pages)
      : report_(report),
        views_(views),
        pdf_({fmt::format("Morgagni: {}", report.source.case_name),
              report.author,
              report.title.created_at,
              fmt::format("{}  \xC2\xB7  {}", report.source.case_name, report.title.created_at),
              fmt::format("Morgagni {}  \xC2\xB7  not a medical device", kVersion)},
             num_pages) {}

  Result<std::string> compose() {
    cover();
    views();
    findings();
    pictures();
    hashes();
    num_pages_ = pdf_.num_pages();
    return pdf_.finish();
  }

  int num_pages() const { return num_pages_; }

 private:
  void cover() {
    pdf_.set_y(92.0);
    pdf_.text("CT and body surface", PdfStyle::kSubtitle);
    pdf_.skip(4.0);
    pdf_.text(report_.source.case_name, PdfStyle::kTitle);
    pdf_.skip(4.0);
    pdf_.text(report_.source.ct_description, PdfStyle::kSubtitle);
    pdf_.skip(18.0);
    pdf_.line(PdfWriter::kLeft, pdf_.y(), PdfWriter::kLeft + 56.0, pdf_.y(), 2.0);
    pdf_.skip(16.0);
    pdf_.fact("Made", report_.title.created_at + " (UTC)");
    pdf_.fact("By", report_.author);
    pdf_.fact("With", fmt::format("Morgagni {}", kVersion));
    for (const auto& fact : report_.source.facts) {
      const bool is_hash = fact.value.size() == 64 && fact.value.find(' ') == std::string::npos;
      pdf_.fact(fact.name, fact.value, is_hash ? PdfStyle::kMono : PdfStyle::kBody);
    }
    pdf_.fact("Colours of the skin", texture_words(report_));
    pdf_.fact("Findings", fmt::format("{}", report_.source.findings.size()));
    pdf_.heading("What to know when reading");
    pdf_.text(
        "Not a medical device. For research, teaching and forensic documentation; no "
        "diagnosis, no treatment.",
        PdfStyle::kStrong);
    pdf_.skip(5.0);
    pdf_.text(kBoundWords, PdfStyle::kBody);
    pdf_.skip(5.0);
    pdf_.text(kCoordinateWords, PdfStyle::kBody);
  }

  void views() {
    pdf_.new_page();
    pdf_.heading("The body from four sides");
    const double width = 0.5 * (PdfWriter::kWidth - kGap);
    const double height = 0.5 * (PdfWriter::kBottom - pdf_.y()) - 48.0;
    const double top = pdf_.y();
    static constexpr std::array kCaptions = {"From the front",
                                             "From the back",
                                             "From the body\xE2\x80\x99s left",
                                             "From the body\xE2\x80\x99s right"};
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const double x = PdfWriter::kLeft + static_cast<double>(i % 2) * (width + kGap);
      const double y = top + static_cast<double>(i / 2) * (height + 30.0);
      draw_view(views_[i], {x, y, width, height}, kCaptions[i]);
    }
    pdf_.set_y(top + 2.0 * (height + 30.0));
    pdf_.text(
        "Without perspective: the scale holds in all of a picture. Grey skin was never seen "
        "by the camera; dark brown is the skin's inner side, where the CT ends. Numbers are "
        "those of the findings.",
        PdfStyle::kSmall);
  }

  void draw_view(const BodyPicture& view, const PdfBox& box, const std::string& caption) {
    pdf_.image(view.picture, box);
    const double pt_per_px = box.width / view.picture.width();
    draw_findings(view, box, pt_per_px);
    pdf_.frame(box);
    const Eigen::Vector3d quiet(0.25, 0.27, 0.30);
    const auto letter = [&](std::size_t i, double x, double y, double align) {
      pdf_.label(std::string(view.letters[i]), PdfStyle::kStrong, x, y, align, quiet);
    };
    letter(0, box.x + 5.0, box.y + 0.5 * box.height - 6.0, 0.0);
    letter(1, box.x + box.width - 5.0, box.y + 0.5 * box.height - 6.0, 1.0);
    letter(2, box.x + 0.5 * box.width, box.y + 3.0, 0.5);
    letter(3, box.x + 0.5 * box.width, box.y + box.height - 16.0, 0.5);
    const double pt_per_mm = pt_per_px / view.mm_per_px;
    const double length_mm = round_length(0.3 * box.width / pt_per_mm);
    const double y = box.y + box.height - 7.0;
    const double x = box.x + 7.0;
    pdf_.line(x, y, x + length_mm * pt_per_mm, y, 1.4);
    pdf_.line(x, y - 3.0, x, y + 3.0, 0.8);
    pdf_.line(x + length_mm * pt_per_mm, y - 3.0, x + length_mm * pt_per_mm, y + 3.0, 0.8);
    pdf_.label(fmt::format("{:g} mm", length_mm), PdfStyle::kTiny, x + 3.0, y - 12.5);
    pdf_.label(caption, PdfStyle::kSmall, box.x, box.y + box.height + 4.0);
  }

  void draw_findings(const BodyPicture& view, const PdfBox& box, double pt_per_px) {
    const auto on_paper = [&](const Eigen::Vector3d& ct_mm) {
      const Eigen::Vector2d px = view.place_px(ct_mm);
      return Eigen::Vector2d(box.x + (px.x() + 0.5) * pt_per_px,
                             box.y + (px.y() + 0.5) * pt_per_px);
    };
    for (const auto& finding : report_.source.findings) {
      std::vector<Eigen::Vector3d> way = finding.path_ct_mm;
      if (way.empty()) {
        for (const auto& point : finding.points) way.push_back(point.ct_mm);
      }
      for (std::size_t i = 1; i < way.size(); ++i) {
        if (!view.is_visible(way[i - 1]) || !view.is_visible(way[i])) continue;
        const auto a = on_paper(way[i - 1]);
        const auto b = on_paper(way[i]);
        if (finding.kind == FindingKind::kDistance) {
          pdf_.dashed_line(a.x(), a.y(), b.x(), b.y());
        } else {
          pdf_.line(a.x(), a.y(), b.x(), b.y(), 1.0, 0.2);
        }
      }
      bool is_numbered = false;
      for (const auto& point : finding.points) {
        if (!view.is_visible(point.ct_mm)) continue;
        const auto place = on_paper(point.ct_mm);
        pdf_.disc(place.x(), place.y(), 2.6, kPinColor);
        if (!std::exchange(is_numbered, true))
          pdf_.label(
              finding.id, PdfStyle::kStrong, place.x() + 4.0, place.y() - 13.0, 0.0, kPinColor);
      }
    }
  }

  void findings() {
    pdf_.new_page();
    pdf_.heading("Findings");
    if (report_.source.findings.empty()) pdf_.text("No findings were recorded.", PdfStyle::kBody);
    for (const auto& finding : report_.source.findings) show_finding(finding);
  }

  void show_finding(const Finding& finding) {
    constexpr double kPhotoWidth = 150.0;
    const auto photo = photo_of(finding);
    const double photo_height =
        photo ? kPhotoWidth * photo->height() / std::max(1, photo->width()) : 0.0;
    pdf_.keep_together(std::max(90.0, std::min(photo_height, 300.0) + 20.0));
    const double top = pdf_.y();
    const int page = pdf_.num_pages();
    double width = PdfWriter::kWidth;
    if (photo) {
      width -= kPhotoWidth + kGap;
      const PdfBox box{PdfWriter::kLeft + width + kGap, top + 2.0, kPhotoWidth, photo_height};
      pdf_.image(*photo, box);
      pdf_.frame(box);
    }
    pdf_.text(fmt::format("{}  \xC2\xB7  {}", finding.id, kind_words(finding.kind)),
              PdfStyle::kStrong,
              PdfWriter::kLeft,
              width);
    pdf_.text(finding.created_at, PdfStyle::kSmall, PdfWriter::kLeft, width);
    pdf_.skip(2.0);
    if (!finding.note.empty()) pdf_.text(finding.note, PdfStyle::kBody, PdfWriter::kLeft, width);
    pdf_.skip(2.0);
    if (finding.length_mm) {
      pdf_.text(
          fmt::format("{:.1f} mm, {}", *finding.length_mm, plus_minus(finding.length_bound_mm)),
          PdfStyle::kStrong,
          PdfWriter::kLeft,
          width);
    }
    for (std::size_t i = 0; i < finding.points.size(); ++i) {
      const auto& point = finding.points[i];
      pdf_.text(fmt::format("{}({:.1f}, {:.1f}, {:.1f}) mm, {}, {}",
                            finding.points.size() > 1 ? fmt::format("{}: ", i + 1) : "",
                            point.ct_mm.x(),
                            point.ct_mm.y(),
                            point.ct_mm.z(),
                            point.is_on_skin ? "on the skin" : "inside the body",
                            plus_minus(point.bound_mm)),
                PdfStyle::kSmall,
                PdfWriter::kLeft,
                width);
    }
    if (!finding.photo.empty() && !photo)
      pdf_.text("Its photo could not be read: " + finding.photo, PdfStyle::kSmall);
    if (photo && pdf_.num_pages() == page) pdf_.set_y(std::max(pdf_.y(), top + photo_height + 6.0));
    pdf_.skip(6.0);
    pdf_.rule();
    pdf_.skip(8.0);
  }

  std::optional<Image<Rgb8>> photo_of(const Finding& finding) const {
    const bool is_plain_name = !finding.photo.empty() &&
                               finding.photo.find('/') == std::string::npos &&
                               !finding.photo.starts_with('.');
    if (!is_plain_name) return std::nullopt;
    auto photo = read_png_rgb(report_.source.findings_folder / finding.photo);
    if (!photo || photo->empty()) return std::nullopt;
    return *std::move(photo);
  }

  void pictures() {
    if (report_.source.pictures.empty()) return;
    pdf_.new_page();
    pdf_.heading("Pictures");
    for (const auto& kept : report_.source.pictures) {
      const auto picture = read_png_rgb(kept.file);
      if (!picture || picture->empty()) {
        pdf_.text("Could not be read: " + kept.file.filename().string(), PdfStyle::kSmall);
        continue;
      }
      const double height = std::min(PdfWriter::kWidth * picture->height() / picture->width(),
                                     0.5 * PdfWriter::kBottom);
      const double width = height * picture->width() / picture->height();
      pdf_.keep_together(height + 34.0);
      pdf_.image(*picture, {PdfWriter::kLeft, pdf_.y(), width, height});
      pdf_.skip(height + 4.0);
      pdf_.text(kept.caption, PdfStyle::kSmall);
      pdf_.skip(12.0);
    }
  }

  void hashes() {
    if (!report_.source.findings.empty() || !report_.source.pictures.empty()) pdf_.new_page();
    pdf_.heading("Files and their SHA-256");
    pdf_.text(
        "A file is the one meant here when its SHA-256 is the same, as `sha256sum` or any such "
        "program computes it. This report's own stands in manifest.json beside it.",
        PdfStyle::kSmall);
    for (const auto& remark : report_.remarks) {
      pdf_.skip(5.0);
      pdf_.text(remark, PdfStyle::kBody);
    }
    pdf_.skip(8.0);
    pdf_.text("Exported with this report", PdfStyle::kStrong);
    hash_table(report_.files);
    pdf_.skip(10.0);
    pdf_.text("The case that they were made from", PdfStyle::kStrong);
    hash_table(report_.source.case_files);
  }

  void hash_table(const std::vector<HashedFile>& files) {
    pdf_.skip(3.0);
    if (files.empty()) pdf_.text("none", PdfStyle::kSmall);
    for (const auto& file : files) {
      pdf_.keep_together(24.0);
      const double y = pdf_.y();
      pdf_.label(size_words(file.num_bytes),
                 PdfStyle::kSmall,
                 PdfWriter::kLeft + PdfWriter::kWidth,
                 y,
                 1.0);
      pdf_.text(file.name, PdfStyle::kSmall, PdfWriter::kLeft, PdfWriter::kWidth - 70.0);
      pdf_.text(file.sha256, PdfStyle::kMono);
      pdf_.skip(5.0);
    }
  }

  const Report& report_;
  const std::vector<BodyPicture>& views_;
  PdfWriter pdf_;
  int num_pages_ = 0;
};

}  // namespace

Result<std::string> encode_report_pdf(const Report& report) {
  std::vector<BodyPicture> views;
  const double width_pt = 0.5 * (PdfWriter::kWidth - kGap);
  const double height_pt = 0.5 * (PdfWriter::kBottom - PdfWriter::kTop - 30.0) - 48.0;
  for (const auto view :
       {BodyView::kAnterior, BodyView::kPosterior, BodyView::kLeft, BodyView::kRight}) {
    views.push_back(draw_body(report.model,
                              view,
                              static_cast<int>(width_pt / 72.0 * kPictureDpi),
                              static_cast<int>(height_pt / 72.0 * kPictureDpi)));
  }
  // Once to count the pages, once with the count on each.
  Composer draft(report, views, 0);
  if (auto pages = draft.compose(); !pages) return pages;
  Composer composer(report, views, draft.num_pages());
  return composer.compose();
}

}  // namespace mor
