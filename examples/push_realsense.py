#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""Pushes a RealSense (D400, L500) to Morgagni.

    pip install pyrealsense2 websocket-client pillow
    morgagni serve --case cases/0815 --camera push:8765
    python3 push_realsense.py ws://127.0.0.1:8765
"""
import sys

import pyrealsense2 as rs

from morgagni_push import Camera, Push

WIDTH, HEIGHT, RATE = 640, 480, 30


def camera(profile):
    i = profile.as_video_stream_profile().get_intrinsics()
    return Camera(i.width, i.height, i.fx, i.fy, i.ppx, i.ppy, i.coeffs)


def main(url):
    config = rs.config()
    config.enable_stream(rs.stream.depth, WIDTH, HEIGHT, rs.format.z16, RATE)
    config.enable_stream(rs.stream.color, WIDTH, HEIGHT, rs.format.rgb8, RATE)
    pipeline = rs.pipeline()
    streams = pipeline.start(config)
    scale_m = streams.get_device().first_depth_sensor().get_depth_scale()
    if abs(scale_m - 0.001) > 1e-6:
        sys.exit(f"a step of depth is {scale_m} m, it must be 0.001: set 'Depth Units' in the RealSense Viewer")
    depth, color = streams.get_stream(rs.stream.depth), streams.get_stream(rs.stream.color)
    between = depth.get_extrinsics_to(color)  # A rotation by columns, and metres.
    rotation = [between.rotation[row::3] for row in range(3)]
    serial = streams.get_device().get_info(rs.camera_info.serial_number)
    push = Push(url, camera(depth), camera(color), rotation, between.translation, f"realsense-{serial}")
    while True:
        frames = pipeline.wait_for_frames()
        depth_frame, color_frame = frames.get_depth_frame(), frames.get_color_frame()
        if depth_frame and color_frame:  # One stamp for both: the RealSense library has paired them.
            push.send(depth_frame.get_timestamp() / 1000, depth_frame.get_data(), color_frame.get_data())


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "ws://127.0.0.1:8765")
