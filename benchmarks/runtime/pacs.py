# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""How long `morgagni pacs get` takes for a real chest CT of 138 slices out of a real Orthanc, by each way.

Usage: python3 benchmarks/runtime/pacs.py MORGAGNI DATA_FOLDER [REPETITIONS]

The whole command is timed: query, transfer, and the files on disk. Every slice is compared with what was put in:
its pixels must be the same, bit for bit (by C-GET and C-MOVE Orthanc drops the blanks of empty names, so whole data
sets differ). Fails beyond 3 s. DCMTK's getscu stands beside it.
"""

import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tests", "pacs"))
import netns  # noqa: E402
from chest import chest_files  # noqa: E402
from orthanc import Orthanc  # noqa: E402

LIMIT_S = 3.0
PATIENT = "LIDC-IDRI-0314"


def timed(call, environment):
    """@return Wall and CPU seconds, of the program and those it started."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    subprocess.run(call, check=True, capture_output=True, env=dict(os.environ, **environment))
    wall = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


PIXEL_BYTES = 512 * 512 * 2


def pixels_of(file_bytes):
    """The pixel data is the last element of these files."""
    return file_bytes[-PIXEL_BYTES:]


def pixels_in(folder):
    all_of_them = []
    for root, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(root, name), "rb") as file:
                all_of_them.append(pixels_of(file.read()))
    return sorted(all_of_them)


def main():
    morgagni, data, repetitions = os.path.abspath(sys.argv[1]), sys.argv[2], int((sys.argv[3:] or ["10"])[0])
    scratch = tempfile.mkdtemp(prefix="mor_pacs_benchmark_")
    orthanc = Orthanc(scratch + "/orthanc")
    too_slow = False
    try:
        slices = chest_files(data)
        for file in slices:
            orthanc.store(file)
        wanted = sorted(map(pixels_of, slices))
        study = subprocess.run([morgagni, "pacs", "query", f"dicom://ORTHANC@127.0.0.1:{Orthanc.DICOM_PORT}"],
                               check=True, capture_output=True, text=True).stdout.split("\n")[0].split()[-1]
        get = [morgagni, "pacs", "get"]
        more = ["--patient-id", PATIENT, "--out", scratch + "/out"]
        dicom = f"dicom://ORTHANC@127.0.0.1:{Orthanc.DICOM_PORT}"
        ways = {
            "DICOMweb": [*get, f"http://127.0.0.1:{Orthanc.HTTP_PORT}/dicom-web", "--user", "anna", *more],
            "C-GET": [*get, dicom, *more],
            "C-MOVE": [*get, dicom, "--by", "move", *more],
            "(getscu)": ["getscu", "-S", "-aet", "MORGAGNI", "-aec", "ORTHANC", "-k", "0008,0052=STUDY",
                         "-k", f"0020,000D={study}", "-od", scratch + "/out", "127.0.0.1", str(Orthanc.DICOM_PORT)],
        }
        print(f"{len(slices)} slices, {sum(map(len, slices)) / 1e6:.1f} MB, {repetitions} times\n")
        print("| way | wall s, median | largest | CPU s, median | MB/s |\n|---|---|---|---|---|")
        for name, call in ways.items():
            times = []
            for _ in range(repetitions):
                if name == "(getscu)":
                    os.makedirs(scratch + "/out")
                times.append(timed(call, {"MORGAGNI_PACS_PASSWORD": "geheim", "TCP_NODELAY": "1"}))
                if name != "(getscu)":
                    assert pixels_in(scratch + "/out") == wanted, f"{name}: what came is not what is kept there"
                shutil.rmtree(scratch + "/out")
            wall = statistics.median(t[0] for t in times)
            too_slow = too_slow or wall > LIMIT_S
            print(f"| {name} | {wall:.2f} | {max(t[0] for t in times):.2f} | {statistics.median(t[1] for t in times):.2f}"
                  f" | {sum(map(len, slices)) / 1e6 / wall:.0f} |")
    finally:
        orthanc.stop()
        shutil.rmtree(scratch)
    return 1 if too_slow else 0


if __name__ == "__main__":
    netns.enter()
    sys.exit(main())
