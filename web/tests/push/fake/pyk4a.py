# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""What examples/push_azure_kinect.py uses of pyk4a, around a camera that is none."""
import struct
import time
from types import SimpleNamespace as Some

from cv2 import Picture

CalibrationType = Some(DEPTH="depth", COLOR="color")
ColorResolution = Some(RES_720P="720p")
DepthMode = Some(NFOV_UNBINNED="640x576")
Config = Some


class _Calibration:
    def get_camera_matrix(self, kind):
        focal = {"depth": 504.5, "color": 610.5}[kind]
        return [[focal, 0.0, 319.5], [0.0, focal + 1, 239.25], [0.0, 0.0, 1.0]]

    def get_distortion_coefficients(self, kind):
        return [0.5, -2.7, 0.001, 0.0, 1.5, 0.4, -2.5, 1.4]

    def convert_3d_to_3d(self, point, source, target):
        # A quarter turn about z, x goes to y, and a way; millimetres.
        assert (source, target) == ("depth", "color")
        x, y, z = point
        return -y - 32.0, x - 2.0, z + 4.0


class PyK4A:
    serial = "000123400112"
    calibration = _Calibration()

    def __init__(self, config):
        assert config == Some(color_resolution="720p", depth_mode="640x576", synchronized_images_only=True)

    def start(self):
        self.is_started = True

    def get_capture(self):
        assert self.is_started
        time.sleep(0.03)
        depth = struct.pack("<H", 0) + struct.pack("<H", 801) * (640 * 576 - 1)
        color = bytes([50, 100, 200, 255]) * (1280 * 720)
        return Some(depth=Picture(640, 576, 2, depth), color=Picture(1280, 720, 4, color))
