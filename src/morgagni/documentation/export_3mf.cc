// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include <iterator>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/image_png.h"
#include "morgagni/core/version.h"
#include "morgagni/core/xml_text.h"
#include "morgagni/documentation/export_formats.h"
#include "morgagni/documentation/internal/zip_writer.h"

namespace mor {
namespace {

using internal::ZipPart;

constexpr const char* kPictureFile = "3D/Textures/skin.png";
constexpr Rgb8 kCutColor{196, 120, 110};  ///< What closes the skin: no skin was there.
// Numbers of the resources inside the file.
constexpr int kMaterials = 1;
constexpr int kPicture = 2;
constexpr int kPicturePlaces = 3;
constexpr int kFirstObject = 4;

constexpr const char* kContentTypes = R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
<Default Extension="png" ContentType="image/png"/>
</Types>
)";
constexpr const char* kStart = R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";
constexpr const char* kPictureRelation = R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/Textures/skin.png" Id="rel1" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"/>
</Relationships>
)";

/// Grows the model's XML.
class ModelXml {
 public:
  ModelXml(const ExportTitle& title, const std::string& description) {
    print(R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
<metadata name="Title">{}</metadata>
<metadata name="Application">Morgagni {}</metadata>
<metadata name="CreationDate">{}</metadata>
<metadata name="Description">{}</metadata>
<resources>
)",
          xml_text(title.title),
          kVersion,
          title.created_at,
          xml_text(description));
  }

  template <class... Values>
  void print(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  void begin_materials() { print("<basematerials id=\"{}\">\n", kMaterials); }
  void add_material(const std::string& name, Rgb8 color) {
    print("<base name=\"{}\" displaycolor=\"#{:02X}{:02X}{:02X}FF\"/>\n",
          xml_text(name),
          color.r,
          color.g,
          color.b);
  }
  void end_materials() { print("</basematerials>\n"); }

  void begin_object(int id, const std::string& name, bool is_solid, std::size_t material) {
    print("<object id=\"{}\" type=\"{}\" name=\"{}\" pid=\"{}\" pindex=\"{}\"><mesh><vertices>\n",
          id,
          is_solid ? "model" : "surface",
          xml_text(name),
          kMaterials,
          material);
  }
  void add_vertices(const TriangleMesh& mesh) {
    for (const auto& v : mesh.vertices)
      print("<vertex x=\"{:.4f}\" y=\"{:.4f}\" z=\"{:.4f}\"/>\n", v.x(), v.y(), v.z());
    print("</vertices><triangles>\n");
  }
  void add_triangle(const Triangle& t) {
    print("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", t[0], t[1], t[2]);
  }
  void end_object() { print("</triangles></mesh></object>\n"); }

  std::string finish(int num_objects) {
    print("</resources>\n<build>\n");
    for (int i = 0; i < num_objects; ++i) print("<item objectid=\"{}\"/>\n", kFirstObject + i);
    print("</build>\n</model>\n");
    return std::move(text_);
  }

 private:
  std::string text_;
};

void add_picture_places(ModelXml& xml, const ExportModel& model) {
  xml.print(
      "<m:texture2d id=\"{}\" path=\"/{}\" contenttype=\"image/png\" tilestyleu=\"clamp\" "
      "tilestylev=\"clamp\"/>\n<m:texture2dgroup id=\"{}\" texid=\"{}\">\n",
      kPicture,
      kPictureFile,
      kPicturePlaces,
      kPicture);
  for (const auto& place : model.skin.picture_px) {
    const auto share = picture_share(place, model.picture);
    xml.print("<m:tex2coord u=\"{:.7f}\" v=\"{:.7f}\"/>\n", share.x(), 1.0F - share.y());
  }
  xml.print("</m:texture2dgroup>\n");
}

void add_skin_triangle(ModelXml& xml, const Triangle& t, const Triangle& places) {
  xml.print("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\" pid=\"{}\" p1=\"{}\" p2=\"{}\" p3=\"{}\"/>\n",
            t[0],
            t[1],
            t[2],
            kPicturePlaces,
            places[0],
            places[1],
            places[2]);
}

void add_closing_triangle(ModelXml& xml, const Triangle& t) {
  xml.print("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\" pid=\"{}\" p1=\"1\"/>\n",
            t[0],
            t[1],
            t[2],
            kMaterials);
}

Result<std::string> package(std::string model_xml, const Image<Rgb8>& picture) {
  std::vector<ZipPart> parts = {{"[Content_Types].xml", kContentTypes},
                                {"_rels/.rels", kStart},
                                {"3D/3dmodel.model", std::move(model_xml)}};
  if (!picture.empty()) {
    const auto png = encode_png(picture.view());
    parts.push_back({"3D/_rels/3dmodel.model.rels", kPictureRelation});
    parts.push_back(
        {kPictureFile, std::string(reinterpret_cast<const char*>(png.data()), png.size())});
  }
  return internal::zip(parts);
}

}  // namespace

Result<std::string> encode_skin_3mf(const ExportModel& model,
                                    const PrintableSolid& solid,
                                    const ExportTitle& title) {
  ModelXml xml(title,
               "The skin of a CT, closed for printing. The closing faces are no skin: the CT ends "
               "there. x to the body's left, y to the back, z to the head.");
  xml.begin_materials();
  xml.add_material("skin", model.skin.color);
  xml.add_material("closing", kCutColor);
  xml.end_materials();
  const bool is_textured = !model.picture.empty();
  if (is_textured) add_picture_places(xml, model);
  xml.begin_object(kFirstObject, "skin", check_solid(solid.mesh).is_solid(), 0);
  xml.add_vertices(solid.mesh);
  for (std::size_t i = 0; i < solid.mesh.triangles.size(); ++i) {
    if (i >= solid.num_skin_triangles) {
      add_closing_triangle(xml, solid.mesh.triangles[i]);
    } else if (is_textured) {
      add_skin_triangle(xml, solid.mesh.triangles[i], model.skin.mesh.triangles[i]);
    } else {
      xml.add_triangle(solid.mesh.triangles[i]);
    }
  }
  xml.end_object();
  return package(xml.finish(1), model.picture);
}

Result<std::string> encode_structures_3mf(const ExportModel& model, const ExportTitle& title) {
  ModelXml xml(title, "Structures of a CT. x to the body's left, y to the back, z to the head.");
  xml.begin_materials();
  for (const auto& structure : model.structures) xml.add_material(structure.name, structure.color);
  xml.end_materials();
  for (std::size_t i = 0; i < model.structures.size(); ++i) {
    const auto& structure = model.structures[i];
    xml.begin_object(kFirstObject + static_cast<int>(i),
                     structure.name,
                     check_solid(structure.mesh).is_solid(),
                     i);
    xml.add_vertices(structure.mesh);
    for (const auto& triangle : structure.mesh.triangles) xml.add_triangle(triangle);
    xml.end_object();
  }
  return package(xml.finish(static_cast<int>(model.structures.size())), {});
}

}  // namespace mor
