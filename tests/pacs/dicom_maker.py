# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""DICOM files made from scratch: CT series of a round body, and others that are none."""

import array
import os
import struct

EXPLICIT_LITTLE = "1.2.840.10008.1.2.1"
CT_IMAGE = "1.2.840.10008.5.1.4.1.1.2"
SECONDARY_CAPTURE = "1.2.840.10008.5.1.4.1.1.7"
LONG = {"OB", "OW", "SQ", "UN", "UT"}
ROOT = "1.2.826.0.1.3680043.10.1338"


def element(group, number, vr, value):
    if isinstance(value, str):
        value = value.encode()
    if len(value) % 2:
        value += b"\0" if vr in ("UI", "OB") else b" "
    head = struct.pack("<HH", group, number) + vr.encode()
    if vr in LONG:
        return head + struct.pack("<HI", 0, len(value)) + value
    return head + struct.pack("<H", len(value)) + value


def part10(dataset, sop_class, uid, syntax=EXPLICIT_LITTLE):
    meta = (element(2, 1, "OB", b"\0\1") + element(2, 2, "UI", sop_class) + element(2, 3, "UI", uid) +
            element(2, 0x10, "UI", syntax) + element(2, 0x12, "UI", ROOT + ".1"))
    return bytes(128) + b"DICM" + element(2, 0, "UL", struct.pack("<I", len(meta))) + meta + dataset


def dataset_of(file_bytes):
    """What comes after the file meta information."""
    length = struct.unpack_from("<I", file_bytes, 140)[0]
    return file_bytes[144 + length:]


def round_body(size, num_slices, index):
    """HU of a slice through an ellipsoid with a denser core, in air."""
    pixels = array.array("h", [-1000]) * (size * size)
    z = 2.0 * (index + 0.5) / num_slices - 1.0
    for row in range(size):
        y = 2.4 * (row + 0.5) / size - 1.2
        for column in range(size):
            x = 2.4 * (column + 0.5) / size - 1.2
            r = x * x + y * y + 0.8 * z * z
            if r < 0.12:
                pixels[row * size + column] = 900
            elif r < 1.0:
                pixels[row * size + column] = 40
    return pixels.tobytes()


class Series:
    """@param seed  Tells its UIDs apart."""

    def __init__(self, seed, patient_id="4711", name="Doe^Jane", modality="CT", num_slices=30, size=64,
                 study=None, number="2", description="Thorax", date="20260131", accession="A17"):
        self.study_uid = study or f"{ROOT}.{seed}.1"
        self.uid = f"{ROOT}.{seed}.2"
        self.patient_id, self.name, self.modality = patient_id, name, modality
        self.number, self.description, self.date, self.accession = number, description, date, accession
        self.sop_class = CT_IMAGE if modality == "CT" else SECONDARY_CAPTURE
        self.files = {}
        for index in range(num_slices):
            uid = f"{ROOT}.{seed}.3.{index + 1}"
            self.files[uid] = part10(self._dataset(uid, index, num_slices, size), self.sop_class, uid)

    def _dataset(self, uid, index, num_slices, size):
        gap_mm, pixel_mm = 240.0 / num_slices, 240.0 / size
        return b"".join([
            element(8, 5, "CS", "ISO_IR 192"),
            element(8, 8, "CS", "ORIGINAL\\PRIMARY\\AXIAL"),
            element(8, 0x16, "UI", self.sop_class), element(8, 0x18, "UI", uid),
            element(8, 0x20, "DA", self.date), element(8, 0x30, "TM", "120000"),
            element(8, 0x50, "SH", self.accession), element(8, 0x60, "CS", self.modality),
            element(8, 0x90, "PN", ""), element(8, 0x1030, "LO", "Study of " + self.name),
            element(8, 0x103E, "LO", self.description),
            element(0x10, 0x10, "PN", self.name), element(0x10, 0x20, "LO", self.patient_id),
            element(0x10, 0x30, "DA", ""), element(0x10, 0x40, "CS", "O"),
            element(0x18, 0x50, "DS", f"{gap_mm:.3f}"), element(0x18, 0x5100, "CS", "HFS"),
            element(0x20, 0x0D, "UI", self.study_uid), element(0x20, 0x0E, "UI", self.uid),
            element(0x20, 0x10, "SH", "1"), element(0x20, 0x11, "IS", self.number),
            element(0x20, 0x13, "IS", str(index + 1)),
            element(0x20, 0x32, "DS", f"-120\\-120\\{index * gap_mm:.3f}"),
            element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"), element(0x20, 0x52, "UI", ROOT + ".9"),
            element(0x28, 2, "US", struct.pack("<H", 1)), element(0x28, 4, "CS", "MONOCHROME2"),
            element(0x28, 0x10, "US", struct.pack("<H", size)), element(0x28, 0x11, "US", struct.pack("<H", size)),
            element(0x28, 0x30, "DS", f"{pixel_mm:.4f}\\{pixel_mm:.4f}"),
            element(0x28, 0x100, "US", struct.pack("<H", 16)), element(0x28, 0x101, "US", struct.pack("<H", 16)),
            element(0x28, 0x102, "US", struct.pack("<H", 15)), element(0x28, 0x103, "US", struct.pack("<H", 1)),
            element(0x28, 0x1052, "DS", "0"), element(0x28, 0x1053, "DS", "1"),
            element(0x7FE0, 0x10, "OW", round_body(size, num_slices, index)),
        ])

    def write(self, folder):
        os.makedirs(folder, exist_ok=True)
        for uid, data in self.files.items():
            with open(os.path.join(folder, uid + ".dcm"), "wb") as out:
                out.write(data)
        return folder
