// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
//
// VTK's mappers on render_benchmark's scene: processor time a picture, all threads together, as
// lines "name width height ms".
#include <algorithm>
#include <ctime>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkFloatArray.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShortArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include "chest_scene.h"

namespace mor {
namespace {

constexpr int kRepetitions = 5;

double processor_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

/// A window of the picture's middle: `height_px` rows of a picture that is `full_px` high.
struct Frame {
  int width_px;
  int height_px;
  int full_px;
};

class Scene {
 public:
  explicit Scene(const Frame& frame) : frame_(frame) {
    window_->SetOffScreenRendering(1);
    window_->SetMultiSamples(0);
    window_->SetSize(frame.width_px, frame.height_px);
    window_->AddRenderer(renderer_);
    vtkCamera* const camera = renderer_->GetActiveCamera();
    camera->SetPosition(0.0, -500.0, 0.0);
    camera->SetFocalPoint(0.0, 0.0, 0.0);
    camera->SetViewUp(0.0, 0.0, 1.0);
    const double focal_px = 525.0 * frame.full_px / 480.0;
    camera->SetViewAngle(2.0 * std::atan(0.5 * frame.height_px / focal_px) * 180.0 /
                         std::numbers::pi);
  }

  vtkRenderer& renderer() { return *renderer_; }
  vtkRenderWindow& window() { return *window_; }

  /// Draws, and reads the picture back as the live path does.
  void measure(const std::string& name) {
    renderer_->ResetCameraClippingRange();
    vtkNew<vtkUnsignedCharArray> pixels;
    std::vector<double> times_ms;
    for (int i = 0; i <= kRepetitions; ++i) {
      renderer_->GetActiveCamera()->Modified();
      const double start_ms = processor_ms();
      window_->Render();
      window_->GetPixelData(0, 0, frame_.width_px - 1, frame_.height_px - 1, 0, pixels);
      if (i > 0) times_ms.push_back(processor_ms() - start_ms);
    }
    std::nth_element(times_ms.begin(), times_ms.begin() + kRepetitions / 2, times_ms.end());
    std::cout << name << ' ' << frame_.width_px << ' ' << frame_.height_px << ' '
              << times_ms[kRepetitions / 2] << std::endl;
  }

 private:
  Frame frame_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderer> renderer_;
};

vtkNew<vtkActor> actor_of(const RenderedStructure& structure, double opacity) {
  const auto& [name, mesh, color] = structure;
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> normals;
  normals->SetNumberOfComponents(3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    points->InsertNextPoint(mesh.vertices[i].data());
    normals->InsertNextTuple(mesh.normals[i].data());
  }
  vtkNew<vtkCellArray> cells;
  for (const auto& [a, b, c] : mesh.triangles) cells->InsertNextCell({a, b, c});
  vtkNew<vtkPolyData> surface;
  surface->SetPoints(points);
  surface->SetPolys(cells);
  surface->GetPointData()->SetNormals(normals);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(surface);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetOpacity(opacity);
  return actor;
}

vtkNew<vtkImageData> image_of(const Volume& volume) {
  vtkNew<vtkImageData> image;
  const Eigen::Vector3d origin = volume.ct_from_grid.translation();
  image->SetDimensions(volume.size.data());
  image->SetSpacing(volume.spacing_mm.data());
  image->SetOrigin(origin.data());
  vtkNew<vtkShortArray> hu;
  hu->SetNumberOfValues(static_cast<vtkIdType>(volume.hu.size()));
  std::copy(volume.hu.begin(), volume.hu.end(), hu->GetPointer(0));
  image->GetPointData()->SetScalars(hu);
  return image;
}

vtkNew<vtkVolumeProperty> property_of(VolumePreset preset) {
  vtkNew<vtkPiecewiseFunction> opacity;
  vtkNew<vtkColorTransferFunction> color;
  for (const TransferPoint& point : transfer_points(preset)) {
    opacity->AddPoint(point.hu, point.opacity_per_mm);
    color->AddRGBPoint(point.hu, point.color[0], point.color[1], point.color[2]);
  }
  vtkNew<vtkVolumeProperty> property;
  property->SetScalarOpacity(opacity);
  property->SetColor(color);
  property->SetScalarOpacityUnitDistance(1.0);
  property->SetInterpolationTypeToLinear();
  property->ShadeOn();
  return property;
}

template <class Mapper>
void measure_volume(const std::string& name,
                    const Frame& frame,
                    vtkImageData* image,
                    VolumePreset preset) {
  Scene scene(frame);
  vtkNew<Mapper> mapper;
  mapper->SetInputData(image);
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetSampleDistance(0.7F);  // A sample a voxel.
  vtkNew<vtkVolume> volume;
  volume->SetMapper(mapper);
  volume->SetProperty(property_of(preset));
  scene.renderer().AddVolume(volume);
  scene.measure(name + "/" + std::string(to_string(preset)));
}

void measure_surfaces(const Frame& frame) {
  const RenderScene scene = scene_of(3, nullptr);
  Scene opaque(frame);
  opaque.renderer().AddActor(actor_of(scene.structures[0], 1.0));
  opaque.measure("vtk-surfaces/opaque-40k");
  Scene glass(frame);
  glass.window().SetAlphaBitPlanes(1);
  glass.renderer().SetUseDepthPeeling(1);
  glass.renderer().SetMaximumNumberOfPeels(6);
  glass.renderer().SetOcclusionRatio(0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    glass.renderer().AddActor(actor_of(scene.structures[i], 0.4 + 0.1 * static_cast<double>(i)));
  }
  glass.measure("vtk-surfaces/glass-120k");
}

void measure_all() {
  for (const Frame& frame : {Frame{640, 480, 480}, Frame{1280, 720, 720}}) measure_surfaces(frame);
  const auto image = image_of(*chest_ct());
  for (const auto preset : {VolumePreset::kBone, VolumePreset::kSoftTissue, VolumePreset::kLung}) {
    for (const Frame& frame : {Frame{240, 240, 480}, Frame{640, 480, 480}}) {
      measure_volume<vtkFixedPointVolumeRayCastMapper>("vtk-fixed-point", frame, image, preset);
    }
  }
  measure_volume<vtkGPUVolumeRayCastMapper>(
      "vtk-gpu-mapper", Frame{240, 240, 480}, image, VolumePreset::kBone);
}

}  // namespace
}  // namespace mor

int main() {
  mor::measure_all();
}
