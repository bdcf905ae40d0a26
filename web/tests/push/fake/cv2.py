# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""What examples/push_azure_kinect.py uses of OpenCV. It rectifies nothing; it looks whether it is asked for rightly."""

CV_32FC1, INTER_NEAREST, INTER_LINEAR, COLOR_BGR2RGB = "32FC1", "nearest", "linear", "BGR to RGB"


class Picture:
    """In the place of a numpy array: rows of pixels of so many bytes."""

    def __init__(self, width, height, pixel_bytes, data):
        assert len(data) == width * height * pixel_bytes
        self.size, self.pixel_bytes, self.data = (width, height), pixel_bytes, data

    def __getitem__(self, key):
        assert key == (slice(None), slice(None), slice(None, 3)) and self.pixel_bytes == 4
        kept = bytearray(self.size[0] * self.size[1] * 3)
        for channel in range(3):
            kept[channel::3] = self.data[channel::4]
        return Picture(*self.size, 3, bytes(kept))

    def tobytes(self):
        return self.data


def initUndistortRectifyMap(matrix, distortion, rotation, new_matrix, size, kind):
    assert matrix is new_matrix and len(distortion) == 8 and rotation is None and kind == CV_32FC1
    return ("x", size), ("y", size)


def remap(picture, map_x, map_y, interpolation):
    assert (map_x, map_y) == (("x", picture.size), ("y", picture.size))
    # Between depths there is nothing.
    assert interpolation == (INTER_NEAREST if picture.pixel_bytes == 2 else INTER_LINEAR)
    return picture


def cvtColor(picture, conversion):
    assert conversion == COLOR_BGR2RGB and picture.pixel_bytes == 3 and picture.data[:3] == bytes([50, 100, 200])
    swapped = bytearray(picture.data)
    swapped[0::3], swapped[2::3] = picture.data[2::3], picture.data[0::3]
    return Picture(*picture.size, 3, bytes(swapped))
