// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/still.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <pango/pangocairo.h>
#include <spdlog/fmt/fmt.h>

namespace mor {
namespace {

constexpr int kLeastWidthPx = 1200;  ///< Below, words would be too coarse to read.
constexpr std::array kStyles{std::pair{StillStyle::kPlain, std::string_view("plain")},
                             std::pair{StillStyle::kBurnedIn, std::string_view("burned-in")},
                             std::pair{StillStyle::kBeside, std::string_view("beside")}};

struct Color {
  double r, g, b, a = 1.0;
};
constexpr Color kWhite{1, 1, 1};
constexpr Color kInk{0.08, 0.09, 0.10};
constexpr Color kShade{0.05, 0.06, 0.07, 0.62};
constexpr Color kMark{1.0, 0.82, 0.20};
constexpr Color kPaper{0.985, 0.985, 0.98};

/// Words and lines on a picture; sizes in px of the result.
class Sheet {
 public:
  Sheet(int width, int height)
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height),
                 cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {}

  [[nodiscard]] cairo_t* get() const { return cairo_.get(); }

  void color(const Color& c) const { cairo_set_source_rgba(get(), c.r, c.g, c.b, c.a); }

  void fill(double x, double y, double width, double height, const Color& c) const {
    color(c);
    cairo_rectangle(get(), x, y, width, height);
    cairo_fill(get());
  }

  void stroke(const std::vector<Eigen::Vector2d>& line, double width, const Color& c) const {
    color(c);
    cairo_set_line_width(get(), width);
    cairo_set_line_cap(get(), CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(get(), CAIRO_LINE_JOIN_ROUND);
    for (std::size_t i = 0; i < line.size(); ++i)
      (i == 0 ? cairo_move_to : cairo_line_to)(get(), line[i].x(), line[i].y());
    cairo_stroke(get());
  }

  void ring(const Eigen::Vector2d& at, double radius, double width, const Color& c) const {
    color(c);
    cairo_set_line_width(get(), width);
    cairo_new_path(get());  // Else the arc begins at where the last words did.
    cairo_arc(get(), at.x(), at.y(), radius, 0.0, 2.0 * M_PI);
    cairo_stroke(get());
  }

  struct Words {
    std::shared_ptr<PangoLayout> layout;
    double width = 0.0;
    double height = 0.0;
  };
  /// @param max_width  Longer words are broken into lines. 0: they are not.
  [[nodiscard]] Words words(const std::string& text,
                            double size_px,
                            bool is_bold,
                            double max_width = 0.0) const {
    std::shared_ptr<PangoLayout> layout(pango_cairo_create_layout(get()), g_object_unref);
    PangoFontDescription* const font = pango_font_description_from_string("DejaVu Sans");
    pango_font_description_set_absolute_size(font, size_px * PANGO_SCALE);
    if (is_bold) pango_font_description_set_weight(font, PANGO_WEIGHT_BOLD);
    pango_layout_set_font_description(layout.get(), font);
    pango_font_description_free(font);
    if (max_width > 0.0) {
      pango_layout_set_width(layout.get(), static_cast<int>(max_width * PANGO_SCALE));
      pango_layout_set_wrap(layout.get(), PANGO_WRAP_WORD_CHAR);
    }
    pango_layout_set_text(layout.get(), text.c_str(), static_cast<int>(text.size()));
    int width = 0;
    int height = 0;
    pango_layout_get_pixel_size(layout.get(), &width, &height);
    return {std::move(layout), static_cast<double>(width), static_cast<double>(height)};
  }

  void write(const Words& words, double x, double y, const Color& c, double halo_px = 0.0) const {
    cairo_move_to(get(), x, y);
    if (halo_px > 0.0) {
      pango_cairo_layout_path(get(), words.layout.get());
      color({0, 0, 0, 0.85});
      cairo_set_line_width(get(), halo_px);
      cairo_set_line_join(get(), CAIRO_LINE_JOIN_ROUND);
      cairo_stroke(get());
      cairo_move_to(get(), x, y);
    }
    color(c);
    pango_cairo_show_layout(get(), words.layout.get());
  }

  /// Each pixel as a square of `factor` x `factor`.
  void put_picture(ImageView<const Rgba8> picture, int factor) const {
    cairo_surface_flush(surface_.get());
    unsigned char* const data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    for (int y = 0; y < picture.height() * factor; ++y) {
      auto* const row = reinterpret_cast<std::uint32_t*>(data + std::ptrdiff_t{y} * stride);
      for (int x = 0; x < picture.width() * factor; ++x) {
        const Rgba8& p = picture(x / factor, y / factor);
        row[x] = 0xFF000000U | (std::uint32_t{p.r} << 16U) | (std::uint32_t{p.g} << 8U) | p.b;
      }
    }
    cairo_surface_mark_dirty(surface_.get());
  }

  [[nodiscard]] Image<Rgb8> picture() const {
    cairo_surface_flush(surface_.get());
    const unsigned char* const data = cairo_image_surface_get_data(surface_.get());
    const int stride = cairo_image_surface_get_stride(surface_.get());
    Image<Rgb8> image(cairo_image_surface_get_width(surface_.get()),
                      cairo_image_surface_get_height(surface_.get()));
    for (int y = 0; y < image.height(); ++y) {
      const auto* const row =
          reinterpret_cast<const std::uint32_t*>(data + std::ptrdiff_t{y} * stride);
      for (int x = 0; x < image.width(); ++x) {
        image(x, y) = {static_cast<std::uint8_t>(row[x] >> 16U),
                       static_cast<std::uint8_t>(row[x] >> 8U),
                       static_cast<std::uint8_t>(row[x])};
      }
    }
    return image;
  }

 private:
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
};

/// Where the parts stand and how they look.
struct Look {
  double unit = 1.0;  ///< Height of the words, px.
  Color ink = kWhite;
  double halo_px = 0.0;  ///< Dark rim of what lies on the picture.
};

std::string bound_words(const StillWords& words) {
  if (!words.bound_mm) return "error bound not known";
  return fmt::format("error below {:.1f} mm (95 % of cases)", *words.bound_mm);
}

/// "2026-11-26 16:20:05 UTC", for people.
std::string time_words(std::string taken_at) {
  if (taken_at.size() != 20 || taken_at[10] != 'T' || taken_at[19] != 'Z') return taken_at;
  taken_at[10] = ' ';
  taken_at.replace(19, 1, " UTC");
  return taken_at;
}

void draw_scale(const Sheet& sheet,
                const Look& look,
                const StillWords& words,
                int factor,
                double x,
                double bottom) {
  if (!words.scale_depth_mm) return;
  const ScaleBar bar = scale_bar(words.camera, *words.scale_depth_mm);
  const double length = bar.length_px * factor;
  const double u = look.unit;
  const auto depth =
      sheet.words(fmt::format("{} ({:.0f} mm away)", words.scale_place, *words.scale_depth_mm),
                  0.72 * u,
                  false);
  const auto text = sheet.words(fmt::format("{:g} mm", bar.length_mm), u, true);
  const double bar_y = bottom - depth.height - 0.55 * u;
  const std::vector<Eigen::Vector2d> shape = {
      {x, bar_y - 0.45 * u}, {x, bar_y}, {x + length, bar_y}, {x + length, bar_y - 0.45 * u}};
  if (look.halo_px > 0.0) sheet.stroke(shape, 0.22 * u + look.halo_px, {0, 0, 0, 0.85});
  sheet.stroke(shape, 0.2 * u, look.ink);
  sheet.write(text, x + (0.3 * u), bar_y - text.height - (0.15 * u), look.ink, look.halo_px);
  sheet.write(depth, x, bottom - depth.height, look.ink, look.halo_px);
}

void draw_compass(const Sheet& sheet,
                  const Look& look,
                  const StillWords& words,
                  const Eigen::Vector2d& center,
                  double radius) {
  if (!words.camera_from_ct) return;
  constexpr double kFlat = 0.35;  ///< Shorter arrows point along the view.
  for (const auto& [letter, direction, towards] : compass(*words.camera_from_ct)) {
    const bool is_far = towards < -0.2;
    Color ink = look.ink;
    ink.a = is_far ? 0.55 : 1.0;
    const auto text = sheet.words(std::string(1, letter), look.unit, !is_far);
    const Eigen::Vector2d half(0.5 * text.width, 0.5 * text.height);
    if (direction.norm() < kFlat) {
      if (is_far) continue;  // It lies behind the one that points here.
      if (look.halo_px > 0.0)
        sheet.ring(center, 0.75 * look.unit, 0.1 * look.unit + look.halo_px, {0, 0, 0, 0.85});
      sheet.ring(center, 0.75 * look.unit, 0.1 * look.unit, ink);
      sheet.write(text, center.x() - half.x(), center.y() - half.y(), ink, look.halo_px);
      continue;
    }
    const Eigen::Vector2d from = center + 0.95 * look.unit * direction.normalized();
    const Eigen::Vector2d to = center + radius * direction;
    const Eigen::Vector2d at = to + 0.75 * look.unit * direction.normalized();
    if ((to - center).norm() > (from - center).norm()) {
      if (look.halo_px > 0.0)
        sheet.stroke({from, to}, 0.12 * look.unit + look.halo_px, {0, 0, 0, 0.7});
      sheet.stroke({from, to}, 0.12 * look.unit, ink);
    }
    sheet.write(text, at.x() - half.x(), at.y() - half.y(), ink, look.halo_px);
  }
}

void draw_marks(const Sheet& sheet, double unit, const StillWords& words, int factor) {
  std::vector<Eigen::AlignedBox2d> labels;  // No words on others.
  const auto scaled = [factor](const Eigen::Vector2d& px) {
    return Eigen::Vector2d((px.array() + 0.5) * factor);
  };
  for (const auto& mark : words.marks) {
    Color color = kMark;
    color.a = mark.is_dim ? 0.5 : 1.0;
    std::vector<Eigen::Vector2d> line;
    for (const auto& px : mark.line_px) line.push_back(scaled(px));
    if (line.size() > 1) {
      sheet.stroke(line, 0.32 * unit, {0, 0, 0, 0.6 * color.a});
      sheet.stroke(line, 0.16 * unit, color);
    }
    for (const auto& px : mark.points_px) {
      sheet.ring(scaled(px), 0.42 * unit, 0.34 * unit, {0, 0, 0, 0.6 * color.a});
      sheet.ring(scaled(px), 0.42 * unit, 0.17 * unit, color);
    }
    if (mark.points_px.empty()) continue;
    const Eigen::Vector2d at = scaled(mark.points_px.back());
    const auto text =
        sheet.words(mark.label.empty() ? mark.id : mark.id + "  " + mark.label, 0.85 * unit, true);
    const Eigen::Vector2d start(at.x() + 0.75 * unit, at.y() - 0.5 * text.height);
    Eigen::AlignedBox2d label(start, start + Eigen::Vector2d(text.width, 0.8 * text.height));
    const auto covers = [&](const auto& other) { return other.intersects(label); };
    for (int i = 0; i < 8 && std::any_of(labels.begin(), labels.end(), covers); ++i)
      label.translate(Eigen::Vector2d(0.0, text.height));
    labels.push_back(label);
    sheet.write(text, label.min().x(), label.min().y(), color, 0.24 * unit);
  }
}

Image<Rgb8> burned_in(ImageView<const Rgba8> picture, const StillWords& words, int factor) {
  const int width = picture.width() * factor;
  const int height = picture.height() * factor;
  const Sheet sheet(width, height);
  sheet.put_picture(picture, factor);
  const double u = 0.019 * width;
  draw_marks(sheet, u, words, factor);
  const double gap = 0.7 * u;
  const auto first =
      sheet.words(fmt::format("{}   {}", words.case_name, time_words(words.taken_at)),
                  u,
                  true,
                  width - 2.0 * gap);
  const auto second = sheet.words(
      fmt::format("{}, {}", words.state, bound_words(words)), 0.85 * u, false, width - 2.0 * gap);
  sheet.fill(0, 0, width, first.height + second.height + 1.2 * gap, kShade);
  sheet.write(first, gap, 0.4 * gap, kWhite);
  sheet.write(second, gap, 0.6 * gap + first.height, kWhite);
  const auto notice =
      sheet.words(fmt::format("Not a medical device   {}", words.made_by), 0.75 * u, false);
  sheet.fill(0, height - notice.height - 0.6 * gap, width, notice.height + 0.6 * gap, kShade);
  sheet.write(notice, width - notice.width - gap, height - notice.height - 0.3 * gap, kWhite);
  const double floor = height - notice.height - 1.4 * gap;
  const Look look{.unit = u, .ink = kWhite, .halo_px = 0.22 * u};
  draw_scale(sheet, look, words, factor, gap, floor);
  draw_compass(sheet, look, words, {width - 4.6 * u, floor - 4.0 * u}, 2.6 * u);
  return sheet.picture();
}

Image<Rgb8> beside(ImageView<const Rgba8> picture, const StillWords& words, int factor) {
  const int width = picture.width() * factor;
  const int picture_height = picture.height() * factor;
  const double u = 0.019 * width;
  const double margin = 1.2 * u;
  const int panel = static_cast<int>(std::ceil(9.4 * u));
  const Sheet sheet(width, picture_height + panel);
  sheet.put_picture(picture, factor);
  sheet.fill(0, picture_height, width, panel, kPaper);
  const double top = picture_height + 0.9 * u;
  const double bottom = picture_height + panel - 0.9 * u;
  const Look look{.unit = u, .ink = kInk, .halo_px = 0.0};
  // Scale to the left, words in the middle, compass to the right.
  draw_scale(sheet, look, words, factor, margin, bottom);
  const double words_x = margin + 0.30 * width;
  const double words_width = width - words_x - 10.0 * u;
  double y = top;
  const auto write = [&](const std::string& text, double size, bool is_bold) {
    const auto line = sheet.words(text, size, is_bold, words_width);
    sheet.write(line, words_x, y, kInk);
    y += line.height + 0.25 * u;
  };
  write(words.case_name, 1.1 * u, true);
  write(time_words(words.taken_at), 0.9 * u, false);
  write(fmt::format("{}, {}", words.state, bound_words(words)), 0.9 * u, false);
  write(words.made_by, 0.75 * u, false);
  write("Not a medical device", 0.75 * u, true);
  draw_compass(sheet, look, words, {width - 5.0 * u, picture_height + 0.5 * panel}, 2.6 * u);
  return sheet.picture();
}

Image<Rgb8> plain(ImageView<const Rgba8> picture) {
  Image<Rgb8> image(picture.width(), picture.height());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x)
      image(x, y) = {picture(x, y).r, picture(x, y).g, picture(x, y).b};
  }
  return image;
}

}  // namespace

std::string_view to_string(StillStyle style) {
  return kStyles[static_cast<std::size_t>(style)].second;
}

std::optional<StillStyle> parse_still_style(std::string_view name) {
  for (const auto& [style, its_name] : kStyles) {
    if (its_name == name) return style;
  }
  return std::nullopt;
}

ScaleBar scale_bar(const PinholeCamera& camera, double depth_mm) {
  const double px_per_mm = camera.focal_x_px / depth_mm;
  const double most_mm = 0.25 * camera.width_px / px_per_mm;
  const double decade = std::pow(10.0, std::floor(std::log10(most_mm)));
  const double step = most_mm / decade;
  const double length_mm = decade * (step >= 5.0 ? 5.0 : step >= 2.0 ? 2.0 : 1.0);
  return {length_mm, length_mm * px_per_mm};
}

std::vector<CompassLetter> compass(const Eigen::Isometry3d& camera_from_ct) {
  // LPS: x to the body's left, y to its back, z to its head.
  constexpr std::array<std::pair<char, char>, 3> kLetters{{{'L', 'R'}, {'P', 'A'}, {'H', 'F'}}};
  std::vector<CompassLetter> letters;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d along = camera_from_ct.linear().col(axis);
    const auto& [plus, minus] = kLetters[static_cast<std::size_t>(axis)];
    letters.push_back({plus, along.head<2>(), -along.z()});
    letters.push_back({minus, -along.head<2>(), along.z()});
  }
  std::sort(letters.begin(), letters.end(), [](const auto& a, const auto& b) {
    return a.towards_viewer < b.towards_viewer;
  });
  return letters;
}

Result<Image<Rgb8>> draw_still(ImageView<const Rgba8> picture,
                               const StillWords& words,
                               StillStyle style) {
  const bool fits =
      picture.width() == words.camera.width_px && picture.height() == words.camera.height_px;
  if (picture.empty() || !fits) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("the picture has {} x {} px, its camera {} x {}",
                                  picture.width(),
                                  picture.height(),
                                  words.camera.width_px,
                                  words.camera.height_px));
  }
  const int factor = std::max(1, (kLeastWidthPx + picture.width() - 1) / picture.width());
  switch (style) {
    case StillStyle::kPlain:
      return plain(picture);
    case StillStyle::kBurnedIn:
      return burned_in(picture, words, factor);
    case StillStyle::kBeside:
      return beside(picture, words, factor);
  }
  return plain(picture);
}

}  // namespace mor
