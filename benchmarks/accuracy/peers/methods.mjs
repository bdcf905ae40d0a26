// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause

// What is compared. `starts`: the most starts a frame, so that slow methods that are not in the
// running do not take the whole time; `frames` likewise.

export const OWN_FINE = 'field';
export const OWN_GLOBAL = 'automatic-start';

export const FINE_METHODS = [
  { name: OWN_FINE, program: 'morgagni', starts: 20 },
  { name: 'icp', program: 'morgagni', starts: 1 },
  { name: 'trimmed-icp', program: 'morgagni', starts: 1 },
  { name: 'open3d-point-to-plane', program: 'open3d_peers', starts: 20 },
  { name: 'open3d-registration-icp', program: 'open3d_peers', starts: 3 },
  { name: 'open3d-generalized', program: 'open3d_peers', starts: 3 },
  { name: 'open3d-point-to-point', program: 'open3d_peers', starts: 2 },
  { name: 'pcl-point-to-plane', program: 'pcl_peers', starts: 3 },
  { name: 'pcl-point-to-plane-trimmed', program: 'pcl_peers', starts: 5 },
  { name: 'pcl-gicp', program: 'pcl_peers', starts: 5 },
  { name: 'pcl-icp', program: 'pcl_peers', starts: 1 },
  { name: 'pcl-trimmed-icp', program: 'pcl_peers', starts: 1 },
  { name: 'pcl-ndt', program: 'pcl_peers', starts: 1 },
  { name: 'vtk-icp', program: 'vtk_peers', starts: 1 },
];

export const GLOBAL_METHODS = [
  { name: OWN_GLOBAL, program: 'morgagni', starts: 1 },
  { name: 'open3d-fpfh-ransac', program: 'open3d_peers', starts: 1 },
  { name: 'open3d-fpfh-fgr', program: 'open3d_peers', starts: 1 },
  { name: 'pcl-sac-ia', program: 'pcl_peers', starts: 1, frames: 10 },
  { name: 'pcl-prerejective', program: 'pcl_peers', starts: 1 },
];

export const isPeer = (name) => /^(open3d|pcl|vtk)-/.test(name);
