# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""`morgagni pacs serve`: what others send becomes cases, and nobody who sends nonsense ends it.

Usage: serve_test.py MORGAGNI [unittest's arguments]
"""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import netns
from certificates import make_certificate
from dicom_maker import CT_IMAGE, Series
from hostile_peer import associate_request, command, data_pdu, nested_bomb, pdu, read_pdu

MORGAGNI = os.path.abspath(sys.argv[1])
QUIET_S = 2


class Server:
    """A receiver with its log."""

    def __init__(self, cases, *options):
        call = [MORGAGNI, "pacs", "serve", "--cases", cases, "--port", "0", "--quiet-s", str(QUIET_S), *options]
        self.process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        self.port = int(re.search(r":(\d+), cases", line).group(1)) if line else 0
        self.log = ""
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.log += line

    def wait_for(self, text, seconds=60, times=1):
        deadline = time.time() + seconds
        while self.log.count(text) < times:
            if time.time() > deadline:
                raise AssertionError(f"no \"{text}\" in:\n{self.log}")
            time.sleep(0.05)

    def stop(self, how=signal.SIGTERM):
        self.process.send_signal(how)
        code = self.process.wait(30)
        self.reader.join(5)
        self.process.stdout.close()
        self.process.stderr.close()
        return code


def send(port, folder, *options, called="MORGAGNI", calling="SCANNER"):
    """DCMTK's own sender."""
    return subprocess.run(["storescu", "-aet", calling, "-aec", called, "-to", "20", "+sd", "+r", *options,
                           "127.0.0.1", str(port), folder], capture_output=True, text=True, timeout=120)


class Serve(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.mkdtemp(prefix="mor_serve_")
        cls.body = Series(1, patient_id="../../0042", num_slices=60, size=112)
        cls.scout = Series(2, study=cls.body.study_uid, modality="OT", num_slices=2, number="9")
        cls.study = os.path.join(cls.scratch, "study")
        cls.body.write(cls.study + "/body")
        cls.scout.write(cls.study + "/scout")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def setUp(self):
        self.cases = os.path.join(self.scratch, self.id().split(".")[-1])
        self.servers = []

    def tearDown(self):
        for server in self.servers:
            if server.process.poll() is None:
                server.stop(signal.SIGKILL)

    def serve(self, *options):
        self.servers.append(Server(self.cases, *options))
        return self.servers[-1]

    def case_folders(self):
        return [name for name in os.listdir(self.cases) if name != "received" and ".part-" not in name]

    def received(self, series):
        folder = os.path.join(self.cases, "received", series.study_uid, series.uid)
        return sorted(os.listdir(folder)) if os.path.isdir(folder) else []

    def check_case(self):
        names = self.case_folders()
        self.assertEqual(len(names), 1, names)
        self.assertRegex(names[0], r"^0042_20260131_series2_[0-9a-f]{8}$")
        with open(os.path.join(self.cases, names[0], "case.json")) as file:
            return json.load(file)

    def early_and_late(self):
        """@return Two folders: the study but for a slice, and that slice."""
        late = self.cases + "_late"
        early = shutil.copytree(self.study, self.cases + "_early")
        os.makedirs(late)
        for name in sorted(os.listdir(early + "/body"))[:1]:
            shutil.move(os.path.join(early, "body", name), late)
        return early, late

    def test_a_study_becomes_a_case_and_late_slices_join_it(self):
        server = self.serve()
        early, late = self.early_and_late()
        self.assertEqual(send(server.port, early).returncode, 0)
        server.wait_for("skin of 20000 vertices")
        server.wait_for("left out, no CT: series 9")
        first = self.check_case()
        self.assertEqual(len(self.received(self.body)), 59)
        self.assertEqual(send(server.port, late).returncode, 0)
        server.wait_for("1 new objects, preparing")
        server.wait_for("skin of 20000 vertices", times=2)
        self.assertNotEqual(self.check_case(), first)
        self.assertEqual(self.received(self.body), sorted(uid + ".dcm" for uid in self.body.files))
        self.assertEqual(server.stop(), 0)
        self.assertEqual(os.listdir(os.path.join(self.cases, "received", "waiting")), [])

    def test_goes_on_after_it_was_killed(self):
        server = self.serve()
        self.assertEqual(send(server.port, self.study).returncode, 0)
        server.stop(signal.SIGKILL)
        self.assertEqual(self.case_folders(), [])
        server = self.serve("--forget")
        server.wait_for("skin of 20000 vertices")
        self.check_case()
        deadline = time.time() + 10
        while self.received(self.body) and time.time() < deadline:
            time.sleep(0.05)
        self.assertEqual(self.received(self.body), [])
        self.assertEqual(server.stop(), 0)

    def test_late_slices_do_not_replace_a_case_whose_slices_are_forgotten(self):
        server = self.serve("--forget")
        early, late = self.early_and_late()
        self.assertEqual(send(server.port, early).returncode, 0)
        server.wait_for("skin of 20000 vertices")
        first = self.check_case()
        self.assertEqual(send(server.port, late).returncode, 0)
        server.wait_for("the case stays as it is")
        self.assertEqual(self.check_case(), first)
        self.assertEqual(len(self.received(self.body)), 1)
        self.assertEqual(server.stop(), 0)

    def test_a_case_that_could_not_be_made_is_tried_again_by_the_next_run(self):
        short = Series(3, num_slices=1)
        for times in range(2):
            server = self.serve()
            if times == 0:
                self.assertEqual(send(server.port, short.write(self.cases + "_short")).returncode, 0)
            server.wait_for("no case")
            self.assertEqual(server.stop(), 0)

    def test_no_certificate_no_tls(self):
        ca = make_certificate(self.scratch, "half")
        for given in (["--ca", ca[1]], ["--key", ca[0]], ["--certificate", ca[1]]):
            done = subprocess.run([MORGAGNI, "pacs", "serve", "--cases", self.cases, "--port", "0", *given],
                                  capture_output=True, text=True, timeout=30)
            self.assertEqual(done.returncode, 1, given)
            self.assertIn("TLS needs --certificate and --key", done.stderr)

    def test_ends_at_once_while_it_makes_a_case_and_makes_it_later(self):
        server = self.serve()
        self.assertEqual(send(server.port, self.study).returncode, 0)
        server.wait_for("60 new objects, preparing")
        time.sleep(0.3)
        self.assertEqual(server.stop(signal.SIGINT), -signal.SIGINT)
        self.assertEqual(self.case_folders(), [])
        deadline = time.time() + 20
        while [name for name in os.listdir(self.cases) if ".part-" in name] and time.time() < deadline:
            time.sleep(0.05)
        self.assertEqual(os.listdir(self.cases), ["received"])
        server = self.serve()
        server.wait_for("skin of 20000 vertices")
        self.check_case()
        self.assertEqual(server.stop(), 0)

    def test_knows_who_may_send(self):
        server = self.serve("--accept", "SCANNER")
        self.assertNotEqual(send(server.port, self.study, calling="STRANGER").returncode, 0)
        server.wait_for("STRANGER is not among --accept")
        wrong = send(server.port, self.study, called="OTHER")
        self.assertNotEqual(wrong.returncode, 0)
        self.assertIn("Called AE Title Not Recognized", wrong.stderr + wrong.stdout)
        echo = subprocess.run(["echoscu", "-aet", "SCANNER", "-aec", "MORGAGNI", "127.0.0.1", str(server.port)])
        self.assertEqual(echo.returncode, 0)
        self.assertEqual(self.received(self.body), [])
        self.assertEqual(server.stop(), 0)

    def test_over_tls_it_takes_only_whom_its_authority_vouches_for(self):
        ca = make_certificate(self.scratch, "ca")
        mine, scanner = (make_certificate(self.scratch, name, ca) for name in ("mine", "scanner"))
        stranger = make_certificate(self.scratch, "stranger")
        old = make_certificate(self.scratch, "old", ca, days=-1)
        server = self.serve("--key", mine[0], "--certificate", mine[1], "--ca", ca[1])
        scout = self.study + "/scout"
        trust = ("+cf", ca[1])
        for refused in ((), ("+tla", *trust), ("+tls", *stranger, *trust), ("+tls", *old, *trust)):
            self.assertNotEqual(send(server.port, scout, *refused).returncode, 0, refused)
        self.assertEqual(self.received(self.scout), [])
        sent = send(server.port, scout, "+tls", *scanner, *trust)
        self.assertEqual(sent.returncode, 0, sent.stderr)
        server.wait_for("left out, no CT: series 9")
        self.assertEqual(len(self.received(self.scout)), 2)
        self.assertEqual(server.stop(), 0)

    def test_over_tls_without_an_authority_the_line_alone_is_closed_to_others(self):
        mine = make_certificate(self.scratch, "alone")
        server = self.serve("--key", mine[0], "--certificate", mine[1])
        self.assertNotEqual(send(server.port, self.study + "/scout").returncode, 0, "without TLS")
        sent = send(server.port, self.study + "/scout", "+tla", "+cf", mine[1])
        self.assertEqual(sent.returncode, 0, sent.stderr)
        self.assertEqual(server.stop(), 0)

    def test_says_that_the_disk_is_full(self):
        server = self.serve("--min-free-mb", "1000000")
        sent = send(server.port, self.study + "/scout", "-v")
        self.assertIn("OutOfResources", (sent.stdout + sent.stderr).replace(" ", ""))
        server.wait_for("--min-free-mb")
        self.assertEqual(self.received(self.scout), [])
        self.assertEqual(server.stop(), 0)

    def test_refuses_objects_beyond_its_limit(self):
        big = Series(7, num_slices=1, size=800)
        server = self.serve("--max-object-mb", "1")
        self.assertNotEqual(send(server.port, big.write(os.path.join(self.scratch, "big"))).returncode, 0)
        server.wait_for("--max-object-mb")
        self.assertEqual(self.received(big), [])
        self.assertFalse(any(name.endswith(".part") for _, _, files in os.walk(self.cases) for name in files))
        self.assertEqual(server.stop(), 0)

    def connect(self, server, kind=CT_IMAGE):
        connection = socket.create_connection(("127.0.0.1", server.port), timeout=20)
        connection.sendall(associate_request("MORGAGNI", "SCANNER", kind))
        self.assertEqual(read_pdu(connection)[0], 2)
        return connection

    def test_survives_who_means_ill(self):
        server = self.serve("--timeout-s", "3", "--max-associations", "4")
        store = command(1, 7, CT_IMAGE, True, uid="1.2.3")
        evil_name = command(1, 7, CT_IMAGE, True, uid="../../../../tmp/mor_evil")
        for data in (
                data_pdu(1, True, nested_bomb(20000)),
                data_pdu(1, True, store) + data_pdu(1, False, nested_bomb(20000)),
                data_pdu(1, True, store) + data_pdu(1, False, b"\xff" * 5000),
                data_pdu(1, True, evil_name) + data_pdu(1, False, b"\0" * 500),
                data_pdu(1, True, store) + data_pdu(9, False, b"\0" * 500),
                data_pdu(1, True, b"\x00\x00\x00\x00\xff\xff\xff\x7f" + b"A" * 2000),
                pdu(4, b""), pdu(99, b"x" * 100), b"\x04\x00\xff\xff\xff\xff" + b"y" * 1000):
            with self.connect(server) as connection:
                try:
                    connection.sendall(data)
                    connection.shutdown(socket.SHUT_WR)
                    while connection.recv(65536):
                        pass
                except OSError:
                    pass  # It hung up on us.
        for data in (b"GET / HTTP/1.1\r\n\r\n", b"\x01\x00\xff\xff\xff\xf0" + b"z" * 1000, b""):
            with socket.create_connection(("127.0.0.1", server.port)) as connection:
                connection.sendall(data)
        # Who only holds the line is hung up on, and no more than four may.
        idle = [socket.create_connection(("127.0.0.1", server.port), timeout=20) for _ in range(12)]
        server.wait_for("refused, 4 connections are open already")
        for connection in idle:
            connection.settimeout(20)
            try:
                while connection.recv(100):
                    pass
            except ConnectionError:
                pass
            connection.close()
        self.assertIsNone(server.process.poll())
        self.assertFalse(os.path.exists("/tmp/mor_evil.dcm"))
        leftovers = [name for _, _, files in os.walk(self.cases) for name in files]
        self.assertEqual(leftovers, [])
        time.sleep(0.5)
        self.assertEqual(send(server.port, self.study + "/scout").returncode, 0)
        server.wait_for("left out, no CT")
        self.assertEqual(server.stop(), 0)

    def test_two_receivers_do_not_share_a_folder(self):
        server = self.serve()
        second = subprocess.run([MORGAGNI, "pacs", "serve", "--cases", self.cases, "--port", "0"],
                                capture_output=True, text=True)
        self.assertEqual(second.returncode, 1)
        self.assertIn("another receiver", second.stderr)
        self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    netns.enter()
    if not shutil.which("storescu"):
        netns.skip("storescu is not installed (package dcmtk)")
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
