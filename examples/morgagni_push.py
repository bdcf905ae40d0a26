# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""Pushes depth and colour to `morgagni serve --camera push:8765`. Needs websocket-client and pillow.

The protocol is Foxglove's (clientPublish), the messages are ROS 2's: docs/cameras.md.
"""
import io
import json
import struct
import threading

import websocket
from PIL import Image

CHANNELS = [("depth/image_raw/compressed", "cdr", "sensor_msgs/msg/CompressedImage"),
            ("color/image_raw/compressed", "cdr", "sensor_msgs/msg/CompressedImage"),
            ("depth/camera_info", "json", "sensor_msgs/msg/CameraInfo"),
            ("color/camera_info", "json", "sensor_msgs/msg/CameraInfo"),
            ("tf_static", "json", "tf2_msgs/msg/TFMessage")]
NO_TIME = {"sec": 0, "nanosec": 0}


class Camera:
    """A pinhole camera; distortion: k1, k2, p1, p2, k3 of OpenCV."""

    def __init__(self, width, height, fx, fy, cx, cy, distortion=(0, 0, 0, 0, 0)):
        self.size = (width, height)
        self.info = {"width": width, "height": height, "distortion_model": "plumb_bob", "d": list(distortion),
                     "k": [fx, 0, cx, 0, fy, cy, 0, 0, 1]}


class Push:
    """rotation (three rows) and translation (metres) take a point of the depth camera into the colour camera.

    device: its serial number; what `morgagni calibrate` finds is kept for it.
    """

    def __init__(self, url, depth, color, rotation, translation, device):
        self.cameras = {"depth": depth, "color": color}
        self.socket = websocket.create_connection(url, subprotocols=["foxglove.websocket.v1"])
        threading.Thread(target=self._listen, daemon=True).start()
        self.socket.send(json.dumps({"op": "advertise", "device": device, "channels": [
            {"id": i, "topic": "/camera/" + topic, "encoding": encoding, "schemaName": schema}
            for i, (topic, encoding, schema) in enumerate(CHANNELS)]}))
        for i, frame in ((2, "depth"), (3, "color")):
            self._send_json(i, {"header": {"stamp": NO_TIME, "frame_id": frame}, **self.cameras[frame].info})
        r, w = rotation, (1 + rotation[0][0] + rotation[1][1] + rotation[2][2]) ** 0.5 / 2
        turn = {"x": (r[2][1] - r[1][2]) / (4 * w), "y": (r[0][2] - r[2][0]) / (4 * w),
                "z": (r[1][0] - r[0][1]) / (4 * w), "w": w}
        self._send_json(4, {"transforms": [{
            "header": {"stamp": NO_TIME, "frame_id": "color"}, "child_frame_id": "depth",
            "transform": {"translation": dict(zip("xyz", translation)), "rotation": turn}}]})

    def send(self, stamp_s, depth_mm, color_rgb):
        """Two pictures of one moment: 16-bit millimetres and 8-bit RGB, row by row."""
        self._send_picture(0, "depth", "I;16", stamp_s, depth_mm, format="PNG", compress_level=1)
        self._send_picture(1, "color", "RGB", stamp_s, color_rgb, format="JPEG", quality=92)

    def _send_picture(self, channel, frame, mode, stamp_s, pixels, **packing):
        packed = io.BytesIO()
        Image.frombytes(mode, self.cameras[frame].size, bytes(pixels)).save(packed, **packing)
        stamp = struct.pack("<iI", int(stamp_s), int(stamp_s % 1 * 1e9))
        body = stamp + _text(frame) + _text(packing["format"].lower()) + struct.pack("<I", packed.tell())
        self._send(channel, b"\0\1\0\0" + body + packed.getvalue())  # CDR, little-endian

    def _send_json(self, channel, message):
        self._send(channel, json.dumps(message).encode())

    def _send(self, channel, payload):
        self.socket.send_binary(struct.pack("<BI", 1, channel) + payload)

    def _listen(self):
        for message in iter(self.socket.recv, ""):
            if json.loads(message)["op"] == "status":
                print("Morgagni:", json.loads(message)["message"], flush=True)


def _text(value):
    """A string of CDR: its length with the closing zero, its bytes, zeros up to a multiple of four."""
    raw = value.encode() + b"\0"
    return struct.pack("<I", len(raw)) + raw + bytes(-len(raw) % 4)
