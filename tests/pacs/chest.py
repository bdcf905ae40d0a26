# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""The real chest CT of the data folder: 138 slices (LIDC-IDRI-0314, TCIA, CC BY 3.0)."""

import glob
import os
import tarfile

from netns import skip


def chest_files(data_folder):
    """@return The slices' bytes; skips where they are not there."""
    archives = glob.glob(os.path.join(data_folder, "ct_chest_lidc0314", "*.tar.xz"))
    if not archives:
        skip(f"no real chest CT in {data_folder}/ct_chest_lidc0314")
    with tarfile.open(archives[0]) as archive:
        files = [archive.extractfile(member).read() for member in archive if member.isfile()]
    return [data for data in files if data[128:132] == b"DICM"]
