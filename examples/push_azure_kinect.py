#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""Pushes an Azure Kinect to Morgagni, rectified: its lenses have eight coefficients, Morgagni takes five.

    pip install pyk4a opencv-python websocket-client pillow       (and Microsoft's Azure Kinect SDK)
    morgagni serve --case cases/0815 --camera push:8765
    python3 push_azure_kinect.py ws://127.0.0.1:8765
"""
import sys
import time

import cv2
from pyk4a import CalibrationType, ColorResolution, Config, DepthMode, PyK4A

from morgagni_push import Camera, Push


def rectifier(calibration, kind, width, height):
    """The camera that the rectified pictures have, and what rectifies them."""
    k, d = calibration.get_camera_matrix(kind), calibration.get_distortion_coefficients(kind)
    maps = cv2.initUndistortRectifyMap(k, d, None, k, (width, height), cv2.CV_32FC1)
    return Camera(width, height, k[0][0], k[1][1], k[0][2], k[1][2]), maps


def main(url):
    kinect = PyK4A(Config(color_resolution=ColorResolution.RES_720P, depth_mode=DepthMode.NFOV_UNBINNED,
                          synchronized_images_only=True))
    kinect.start()
    depth, depth_maps = rectifier(kinect.calibration, CalibrationType.DEPTH, 640, 576)
    color, color_maps = rectifier(kinect.calibration, CalibrationType.COLOR, 1280, 720)

    def moved(x, y, z):
        """Where a point (mm) of the depth camera lies in the colour camera."""
        return kinect.calibration.convert_3d_to_3d((x, y, z), CalibrationType.DEPTH, CalibrationType.COLOR)

    origin = moved(0.0, 0.0, 0.0)
    steps = (1000.0, 0.0, 0.0), (0.0, 1000.0, 0.0), (0.0, 0.0, 1000.0)
    axes = [[(a - o) / 1000 for a, o in zip(moved(*step), origin)] for step in steps]
    push = Push(url, depth, color, [list(row) for row in zip(*axes)], [value / 1000 for value in origin],
                f"azure-{kinect.serial}")
    while True:
        capture = kinect.get_capture()
        depth_mm = cv2.remap(capture.depth, *depth_maps, cv2.INTER_NEAREST)
        bgr = cv2.remap(capture.color[:, :, :3], *color_maps, cv2.INTER_LINEAR)
        push.send(time.time(), depth_mm.tobytes(), cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB).tobytes())


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "ws://127.0.0.1:8765")
