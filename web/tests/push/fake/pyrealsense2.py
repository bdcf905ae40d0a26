# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""What examples/push_realsense.py uses of pyrealsense2, around a camera that is none."""
import struct
import time
from types import SimpleNamespace as Some

WIDTH, HEIGHT = 640, 480
camera_info = Some(serial_number="serial number")
stream = Some(depth="depth", color="color")
format = Some(z16="z16", rgb8="rgb8")


class config:
    def __init__(self):
        self.streams = {}

    def enable_stream(self, name, width, height, pixels, rate):
        assert (width, height, rate) == (WIDTH, HEIGHT, 30)
        self.streams[name] = pixels


class _Profile:
    def __init__(self, focal):
        self.focal = focal

    def as_video_stream_profile(self):
        return self

    def get_intrinsics(self):
        return Some(width=WIDTH, height=HEIGHT, fx=self.focal, fy=self.focal + 1, ppx=319.5, ppy=239.25,
                    coeffs=[0.0] * 5)

    def get_extrinsics_to(self, other):
        # A quarter turn about z, by columns: x goes to y.
        return Some(rotation=[0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0], translation=[0.015, 0.0, 0.001])


class _Frame:
    def __init__(self, stamp_ms, data):
        self.get_timestamp = lambda: stamp_ms
        self.get_data = lambda: data


class pipeline:
    def start(self, settings):
        assert settings.streams == {"depth": "z16", "color": "rgb8"}
        profiles = {"depth": _Profile(600.5), "color": _Profile(610.5)}
        sensor = Some(get_depth_scale=lambda: 0.0010000000474974513)
        return Some(get_stream=profiles.get, get_device=lambda: Some(
            first_depth_sensor=lambda: sensor, get_info={"serial number": "904412060323"}.get))

    def wait_for_frames(self):
        time.sleep(0.03)
        depth = struct.pack("<H", 0) + struct.pack("<H", 801) * (WIDTH * HEIGHT - 1)
        color = bytes([200, 100, 50]) * (WIDTH * HEIGHT)
        stamp_ms = time.time() * 1000
        frames = {"depth": _Frame(stamp_ms, depth), "color": _Frame(stamp_ms + 5, color)}
        return Some(get_depth_frame=lambda: frames["depth"], get_color_frame=lambda: frames["color"])
