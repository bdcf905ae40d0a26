# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""One session on real input, end to end: a CT out of a PACS, a case, a Kinect, a recording, its replay.

The CT is real and comes out of a real Orthanc; the Kinect is libfreenect's player of dumps (fakenect), whose
11-bit depth and colour were taken of that CT's skin by the simulated Kinect. docs/real-input.md has what this prints.

Usage: real_input_test.py MORGAGNI REAL_INPUT_HELPER DATA_FOLDER [REPORT.json]
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.request

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "pacs"))
import netns  # noqa: E402
from chest import chest_files  # noqa: E402
from orthanc import Orthanc  # noqa: E402

MORGAGNI, HELPER, DATA = map(os.path.abspath, sys.argv[1:4])
FAKENECT = "/usr/lib/x86_64-linux-gnu/fakenect"
NUM_DUMPED, NUM_RECORDED = 120, 60
PATIENT = "LIDC-IDRI-0314"


class Live:
    """A served case, as its page talks to it."""

    def __init__(self, arguments, environment, log):
        self.process = subprocess.Popen([MORGAGNI, "serve", *arguments], stdout=subprocess.PIPE, stderr=log, text=True,
                                        env=dict(os.environ, **environment))
        line = self.process.stdout.readline()
        self.url = re.search(r"http://[^/ ]+", line).group(0)

    def post(self, path, body):
        request = urllib.request.Request(self.url + path, data=json.dumps(body).encode(), method="POST")
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)

    def wait_until(self, holds, seconds):
        """Reads the status events."""
        deadline = time.time() + seconds
        with urllib.request.urlopen(self.url + "/api/events", timeout=seconds) as events:
            for line in events:
                if line.startswith(b"data:") and holds(json.loads(line[5:])):
                    return
                assert time.time() < deadline, line.decode()

    def get(self, path):
        with urllib.request.urlopen(self.url + path, timeout=60) as answer:
            return json.load(answer)

    def stop(self):
        self.process.terminate()
        self.process.wait(60)
        self.process.stdout.close()


def run(report, name, *call):
    start = time.monotonic()
    done = subprocess.run(call, capture_output=True, text=True, timeout=500)
    report["seconds"][name] = round(time.monotonic() - start, 2)
    assert done.returncode == 0, f"{call}: {done.stderr}"
    return done.stdout


def session(scratch):
    """@return What was measured."""
    report = {"seconds": {}}
    slices = chest_files(DATA)
    report["slices"] = len(slices)
    report["megabytes"] = round(sum(map(len, slices)) / 1e6, 1)
    orthanc = Orthanc(scratch + "/orthanc")
    try:
        for data in slices:
            orthanc.store(data)
        run(report, "pacs get", MORGAGNI, "pacs", "get", f"dicom://ORTHANC@127.0.0.1:{Orthanc.DICOM_PORT}",
            "--patient-id", PATIENT, "--out", scratch + "/ct")
    finally:
        orthanc.stop()
    case, dump = scratch + "/case", scratch + "/kinect"
    run(report, "prepare", MORGAGNI, "prepare", scratch + "/ct", "--case", case)
    run(report, "dump", HELPER, "dump", case, "seed=7", str(NUM_DUMPED), dump)
    page = scratch + "/page"
    os.makedirs(page)
    with open(page + "/index.html", "w") as out:
        out.write("<p>page</p>")
    with open(scratch + "/serve.log", "w") as log:
        live = Live(["--case", case, "--camera", f"freenect:calibration={dump}/kinect.json", "--port", "0",
                     "--web", page], {"LD_LIBRARY_PATH": FAKENECT, "FAKENECT_PATH": dump}, log)
        try:
            start = time.monotonic()
            live.wait_until(lambda status: status["state"] == "tracking", 90)
            report["seconds"]["until tracking"] = round(time.monotonic() - start, 2)
            start = time.monotonic()
            live.post("/api/recording/start", {"color": "lossless"})
            deadline = time.time() + 90
            while (state := live.get("/api/recording"))["frames"] < NUM_RECORDED:
                assert not state["error"] and time.time() < deadline, state
                time.sleep(0.1)
            state = live.post("/api/recording/stop", {})
            report["seconds"]["recording"] = round(time.monotonic() - start, 2)
        finally:
            live.stop()
    recording = os.path.join(case, "recordings", state["file"])
    report["recorded"] = {"frames": state["frames"], "dropped": state["dropped"],
                          "megabytes": round(state["bytes"] / 1e6, 1)}
    report.update(json.loads(run(report, "two replays", HELPER, "replay", case, recording, dump)))
    return report


def check(report):
    frames = report["frames"]
    assert frames == report["recorded"]["frames"] and frames >= NUM_RECORDED, frames
    assert report["replayed"] == [frames, frames], report["replayed"]
    assert report["same_poses"] == frames, f"{report['same_poses']} of {frames} poses are the same, bit for bit"
    assert report["tracked"] >= 0.9 * frames, report["tracked"]
    # The skin is where it truly is, through Orthanc, the driver's 11 bits, the recording and its replay.
    assert report["replay_error_mm"]["median"] < 1.0, report["replay_error_mm"]
    assert report["live_to_replay_mm"]["median"] < 0.5, report["live_to_replay_mm"]


if __name__ == "__main__":
    netns.enter()
    if not os.path.exists(FAKENECT):
        netns.skip(f"{FAKENECT} is absent (package libfreenect-dev)")
    place = tempfile.mkdtemp(prefix="mor_real_input_")
    try:
        measured = session(place)
        print(json.dumps(measured, indent=2))
        if len(sys.argv) > 4:
            with open(sys.argv[4], "w") as file:
                json.dump(measured, file, indent=2)
        check(measured)
    except BaseException:
        if os.path.exists(place + "/serve.log"):
            with open(place + "/serve.log") as file:
                sys.stderr.write(file.read()[-4000:])
        raise
    finally:
        shutil.rmtree(place)
