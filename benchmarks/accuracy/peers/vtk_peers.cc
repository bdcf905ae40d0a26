// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// VTK on a set of problems: vtk_peers PROBLEMS, see answering.h.
#include <cstdio>

#include <vtkCellArray.h>
#include <vtkCellLocator.h>
#include <vtkIterativeClosestPointTransform.h>
#include <vtkLandmarkTransform.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include "answering.h"

namespace mor::peers {
namespace {

vtkNew<vtkPolyData> to_vtk(const TriangleMesh& mesh, const Eigen::Isometry3d& a_from_mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const auto& vertex : mesh.vertices) {
    const Eigen::Vector3d point = a_from_mesh * vertex.cast<double>();
    points->InsertNextPoint(point.data());
  }
  vtkNew<vtkCellArray> triangles;
  for (const auto& triangle : mesh.triangles) {
    triangles->InsertNextCell({triangle[0], triangle[1], triangle[2]});
  }
  vtkNew<vtkPolyData> poly_data;
  poly_data->SetPoints(points);
  poly_data->SetPolys(triangles);
  return poly_data;
}

/// Mesh to mesh: points of the moving mesh to the nearest points on the fixed one's triangles.
class VtkIcp : public Method {
 public:
  explicit VtkIcp(const TriangleMesh& skin) : fixed_(to_vtk(skin, Eigen::Isometry3d::Identity())) {
    // As the transform itself would, so that it finds nothing to build.
    locator_->SetDataSet(fixed_);
    locator_->SetNumberOfCellsPerBucket(1);
    locator_->BuildLocator();
  }

  void set_moving(const TriangleMesh& moving) override { moving_ = &moving; }

  std::optional<Eigen::Isometry3d> align(const Eigen::Isometry3d& fixed_from_moving_init) override {
    vtkNew<vtkIterativeClosestPointTransform> icp;
    const auto moving = to_vtk(*moving_, fixed_from_moving_init);
    icp->SetSource(moving);
    icp->SetTarget(fixed_);
    icp->SetLocator(locator_);
    icp->GetLandmarkTransform()->SetModeToRigidBody();
    icp->SetMaximumNumberOfLandmarks(500);
    icp->SetMaximumNumberOfIterations(100);
    icp->CheckMeanDistanceOn();
    icp->SetMaximumMeanDistance(0.001);
    icp->Update();
    Eigen::Isometry3d fixed_from_init = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        fixed_from_init.matrix()(row, column) = icp->GetMatrix()->GetElement(row, column);
      }
    }
    return fixed_from_init * fixed_from_moving_init;
  }

 private:
  vtkNew<vtkPolyData> fixed_;
  vtkNew<vtkCellLocator> locator_;
  const TriangleMesh* moving_ = nullptr;
};

}  // namespace
}  // namespace mor::peers

int main(int argc, char** argv) {
  using namespace mor::peers;
  const auto problems = read_problems(argc > 1 ? argv[1] : "");
  if (!problems) {
    std::fprintf(stderr, "vtk_peers: %s\n", problems.error().message.c_str());
    return 1;
  }
  MethodMakers makers;
  makers.emplace("vtk-icp", [&] { return std::make_unique<VtkIcp>(problems->fixed); });
  return answer_requests(*problems, makers);
}
