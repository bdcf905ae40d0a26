// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/internal/pdf_writer.h"

#include <algorithm>
#include <utility>

#include <cairo-pdf.h>
#include <pango/pangocairo.h>
#include <spdlog/fmt/fmt.h>

#include "morgagni/core/xml_text.h"

namespace mor::internal {
namespace {

constexpr double kPageWidth = 595.28;  // A4
constexpr double kPageHeight = 841.89;
constexpr double kFactColumn = 132.0;
constexpr double kPointsPerInch = 72.0;  // A font's point is the page's.

struct Look {
  const char* font;  ///< As Pango describes it: families in order of preference, style, size.
  double leading;    ///< Line height over font size.
  double gray;
};

Look look_of(PdfStyle style) {
  switch (style) {
    case PdfStyle::kTitle:
      return {"Noto Serif, DejaVu Serif, serif 30", 1.15, 0.08};
    case PdfStyle::kSubtitle:
      return {"Noto Serif, DejaVu Serif, serif 14", 1.3, 0.30};
    case PdfStyle::kHeading:
      return {"Noto Serif, DejaVu Serif, serif Bold 16", 1.2, 0.08};
    case PdfStyle::kStrong:
      return {"Noto Sans, DejaVu Sans, sans Bold 10", 1.35, 0.08};
    case PdfStyle::kBody:
      return {"Noto Sans, DejaVu Sans, sans 10", 1.4, 0.12};
    case PdfStyle::kSmall:
      return {"Noto Sans, DejaVu Sans, sans 8.5", 1.35, 0.35};
    case PdfStyle::kMono:
      return {"DejaVu Sans Mono, Noto Sans Mono, monospace 7.5", 1.3, 0.12};
    case PdfStyle::kTiny:
      return {"Noto Sans, DejaVu Sans, sans 7.5", 1.3, 0.42};
  }
  return {"sans 10", 1.4, 0.1};
}

/// Words of people, without what a font has no sign for.
std::string printable_text(const std::string& text) {
  std::string result;
  for (const char c : valid_utf8(text)) {
    if (static_cast<unsigned char>(c) >= ' ' || c == '\n') {
      result += c;
    } else {
      result += ' ';
    }
  }
  return result;
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

struct LayoutDeleter {
  void operator()(PangoLayout* layout) const { g_object_unref(layout); }
};
using Layout = std::unique_ptr<PangoLayout, LayoutDeleter>;

}  // namespace

struct PdfWriter::Impl {
  PdfHead head;
  int total;
  std::string bytes;
  cairo_surface_t* surface = nullptr;
  cairo_t* context = nullptr;
  int page = 1;
  double y = kTop;

  Impl(PdfHead document, int num_pages) : head(std::move(document)), total(num_pages) {
    surface = cairo_pdf_surface_create_for_stream(append, &bytes, kPageWidth, kPageHeight);
    cairo_pdf_surface_restrict_to_version(surface, CAIRO_PDF_VERSION_1_5);
    const auto set = [&](cairo_pdf_metadata_t what, const std::string& value) {
      const std::string text = printable_text(value);
      if (!text.empty()) cairo_pdf_surface_set_metadata(surface, what, text.c_str());
    };
    set(CAIRO_PDF_METADATA_TITLE, head.title);
    set(CAIRO_PDF_METADATA_AUTHOR, head.author);
    set(CAIRO_PDF_METADATA_CREATOR, head.foot);
    set(CAIRO_PDF_METADATA_CREATE_DATE, head.created_at);
    context = cairo_create(surface);
  }
  ~Impl() {
    cairo_destroy(context);
    cairo_surface_destroy(surface);
  }

  Layout layout(const std::string& text, PdfStyle style, double width) const {
    const Look look = look_of(style);
    Layout result(pango_cairo_create_layout(context));
    pango_cairo_context_set_resolution(pango_layout_get_context(result.get()), kPointsPerInch);
    PangoFontDescription* font = pango_font_description_from_string(look.font);
    pango_layout_set_font_description(result.get(), font);
    pango_font_description_free(font);
    pango_layout_set_line_spacing(result.get(), static_cast<float>(look.leading / 1.36));
    if (width > 0.0) pango_layout_set_width(result.get(), static_cast<int>(width * PANGO_SCALE));
    pango_layout_set_wrap(result.get(), PANGO_WRAP_WORD_CHAR);
    const std::string shown = printable_text(text);
    pango_layout_set_text(result.get(), shown.data(), static_cast<int>(shown.size()));
    return result;
  }

  void gray(double value) const { cairo_set_source_rgb(context, value, value, value * 1.04); }

  static double height_of(PangoLayout* layout) {
    int height = 0;
    pango_layout_get_size(layout, nullptr, &height);
    return static_cast<double>(height) / PANGO_SCALE;
  }

  static double width_of(PangoLayout* layout) {
    int width = 0;
    pango_layout_get_size(layout, &width, nullptr);
    return static_cast<double>(width) / PANGO_SCALE;
  }

  void show(PangoLayout* layout, double x, double at_y) const {
    cairo_move_to(context, x, at_y);
    pango_cairo_show_layout(context, layout);
  }

  void put(const std::string& text, PdfStyle style, double x, double at_y, double align) const {
    const auto laid = layout(text, style, -1.0);
    gray(look_of(style).gray);
    show(laid.get(), x - align * width_of(laid.get()), at_y);
  }

  /// Head and foot of the page that ends here.
  void end_page() {
    if (page > 1) {
      put(head.running, PdfStyle::kTiny, kLeft, 40.0, 0.0);
      hairline(kLeft, 55.0, kLeft + kWidth);
    }
    hairline(kLeft, kBottom + 14.0, kLeft + kWidth);
    put(head.foot, PdfStyle::kTiny, kLeft, kBottom + 20.0, 0.0);
    put(total > 0 ? fmt::format("Page {} of {}", page, total) : fmt::format("Page {}", page),
        PdfStyle::kTiny,
        kLeft + kWidth,
        kBottom + 20.0,
        1.0);
    cairo_show_page(context);
  }

  void hairline(double x0, double at_y, double x1) const {
    cairo_set_source_rgb(context, 0.72, 0.73, 0.75);
    cairo_set_line_width(context, 0.5);
    cairo_move_to(context, x0, at_y);
    cairo_line_to(context, x1, at_y);
    cairo_stroke(context);
  }

  void next_page() {
    end_page();
    ++page;
    y = kTop;
  }

  /// Line by line, over as many pages as it takes.
  void flow(PangoLayout* layout, double x, double shade) {
    PangoLayoutIter* line = pango_layout_get_iter(layout);
    do {
      int top = 0;
      int bottom = 0;
      pango_layout_iter_get_line_yrange(line, &top, &bottom);
      const double height = static_cast<double>(bottom - top) / PANGO_SCALE;
      if (y + height > kBottom) next_page();
      PangoRectangle extents;
      pango_layout_iter_get_line_extents(line, nullptr, &extents);
      const double baseline =
          static_cast<double>(pango_layout_iter_get_baseline(line) - top) / PANGO_SCALE;
      gray(shade);
      cairo_move_to(context, x + static_cast<double>(extents.x) / PANGO_SCALE, y + baseline);
      pango_cairo_show_layout_line(context, pango_layout_iter_get_line_readonly(line));
      y += height;
    } while (pango_layout_iter_next_line(line) != 0);
    pango_layout_iter_free(line);
  }
};

PdfWriter::PdfWriter(PdfHead head, int num_pages)
    : impl_(std::make_unique<Impl>(std::move(head), num_pages)) {}
PdfWriter::~PdfWriter() = default;

int PdfWriter::num_pages() const {
  return impl_->page;
}
double PdfWriter::y() const {
  return impl_->y;
}
void PdfWriter::set_y(double y) {
  impl_->y = y;
}
void PdfWriter::skip(double height) {
  impl_->y += height;
}
void PdfWriter::new_page() {
  impl_->next_page();
}
void PdfWriter::keep_together(double height) {
  if (impl_->y + height > kBottom && impl_->y > kTop) impl_->next_page();
}

void PdfWriter::heading(const std::string& text) {
  keep_together(80.0);
  if (impl_->y > kTop) skip(16.0);
  const std::string shown = printable_text(text);
  const std::string place =
      fmt::format("page={} pos=[{:.0f} {:.0f}]", impl_->page, kLeft, impl_->y);
  cairo_pdf_surface_add_outline(impl_->surface,
                                CAIRO_PDF_OUTLINE_ROOT,
                                shown.c_str(),
                                place.c_str(),
                                CAIRO_PDF_OUTLINE_FLAG_OPEN);
  this->text(text, PdfStyle::kHeading);
  skip(6.0);
}

void PdfWriter::text(const std::string& text, PdfStyle style, double left, double width) {
  const auto laid = impl_->layout(text, style, width);
  impl_->flow(laid.get(), left, look_of(style).gray);
}

void PdfWriter::fact(const std::string& name, const std::string& value, PdfStyle style) {
  const double width = kWidth - kFactColumn;
  const auto words = impl_->layout(name, PdfStyle::kSmall, kFactColumn - 10.0);
  const auto content = impl_->layout(value.empty() ? "\xE2\x80\x94" : value, style, width);
  keep_together(std::min(Impl::height_of(content.get()) + 8.0, 300.0));
  impl_->gray(look_of(PdfStyle::kSmall).gray);
  impl_->show(words.get(), kLeft, impl_->y + 2.2);
  const int page = impl_->page;
  const double top = impl_->y;
  impl_->flow(content.get(), kLeft + kFactColumn, look_of(PdfStyle::kBody).gray);
  if (impl_->page == page) impl_->y = std::max(impl_->y, top + Impl::height_of(words.get()) + 2.2);
  skip(2.5);
  impl_->hairline(kLeft, impl_->y, kLeft + kWidth);
  skip(3.0);
}

void PdfWriter::rule() {
  impl_->hairline(kLeft, impl_->y, kLeft + kWidth);
}

Eigen::Vector2d PdfWriter::label(const std::string& text,
                                 PdfStyle style,
                                 double x,
                                 double y,
                                 double align,
                                 const Eigen::Vector3d& color) {
  const auto laid = impl_->layout(text, style, -1.0);
  const Eigen::Vector2d size(Impl::width_of(laid.get()), Impl::height_of(laid.get()));
  cairo_set_source_rgb(impl_->context, color.x(), color.y(), color.z());
  impl_->show(laid.get(), x - align * size.x(), y);
  return size;
}

void PdfWriter::image(const Image<Rgb8>& picture, const PdfBox& box) {
  cairo_surface_t* pixels =
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, picture.width(), picture.height());
  unsigned char* rows = cairo_image_surface_get_data(pixels);
  const int stride = cairo_image_surface_get_stride(pixels);
  for (int y = 0; rows != nullptr && y < picture.height(); ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(rows + static_cast<std::ptrdiff_t>(y) * stride);
    for (int x = 0; x < picture.width(); ++x) {
      const Rgb8 color = picture(x, y);
      row[x] = static_cast<std::uint32_t>(color.r) << 16U |
               static_cast<std::uint32_t>(color.g) << 8U | color.b;
    }
  }
  cairo_surface_mark_dirty(pixels);
  cairo_save(impl_->context);
  cairo_translate(impl_->context, box.x, box.y);
  cairo_scale(impl_->context, box.width / picture.width(), box.height / picture.height());
  cairo_set_source_surface(impl_->context, pixels, 0.0, 0.0);
  cairo_paint(impl_->context);
  cairo_restore(impl_->context);
  cairo_surface_destroy(pixels);
}

void PdfWriter::line(double x0, double y0, double x1, double y1, double width, double gray) {
  impl_->gray(gray);
  cairo_set_line_width(impl_->context, width);
  cairo_move_to(impl_->context, x0, y0);
  cairo_line_to(impl_->context, x1, y1);
  cairo_stroke(impl_->context);
}

void PdfWriter::dashed_line(double x0, double y0, double x1, double y1) {
  constexpr std::array<double, 2> kDashes = {3.0, 2.0};
  cairo_set_source_rgb(impl_->context, 0.70, 0.12, 0.10);
  cairo_set_line_width(impl_->context, 1.0);
  cairo_set_dash(impl_->context, kDashes.data(), kDashes.size(), 0.0);
  cairo_move_to(impl_->context, x0, y0);
  cairo_line_to(impl_->context, x1, y1);
  cairo_stroke(impl_->context);
  cairo_set_dash(impl_->context, nullptr, 0, 0.0);
}

void PdfWriter::frame(const PdfBox& box) {
  cairo_set_source_rgb(impl_->context, 0.72, 0.73, 0.75);
  cairo_set_line_width(impl_->context, 0.5);
  cairo_rectangle(impl_->context, box.x, box.y, box.width, box.height);
  cairo_stroke(impl_->context);
}

void PdfWriter::disc(double x, double y, double radius, const Eigen::Vector3d& color) {
  cairo_new_path(impl_->context);
  cairo_arc(impl_->context, x, y, radius, 0.0, 6.2831853);
  cairo_set_source_rgb(impl_->context, color.x(), color.y(), color.z());
  cairo_fill_preserve(impl_->context);
  cairo_set_source_rgb(impl_->context, 1.0, 1.0, 1.0);
  cairo_set_line_width(impl_->context, 0.9);
  cairo_stroke(impl_->context);
}

Result<std::string> PdfWriter::finish() {
  impl_->end_page();
  cairo_surface_finish(impl_->surface);
  const auto status = cairo_status(impl_->context);
  if (status == CAIRO_STATUS_SUCCESS) return std::move(impl_->bytes);
  return make_error(ErrorCode::kInternal,
                    fmt::format("the report could not be set: {}", cairo_status_to_string(status)));
}

}  // namespace mor::internal
