# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""`morgagni pacs query` and `get` against a real Orthanc, a bad network, and servers that mean ill.

Usage: pacs_test.py MORGAGNI [unittest's arguments]
"""

import json
import os
import shutil
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import netns
from certificates import make_certificate
from dicom_maker import CT_IMAGE, Series, dataset_of, part10
from hostile_peer import HostileDicom, HostileWeb, command, data_pdu, nested_bomb, pdu, reply
from orthanc import Orthanc
from proxy import Proxy

MORGAGNI = os.path.abspath(sys.argv[1])
FIND = "1.2.840.10008.5.1.4.1.2.2.1"
USER = ["--user", "anna"]
NUM_SLICES = 30


def run(*arguments, environment=None, timeout=60):
    """@return Exit code, standard output, standard error."""
    full = dict(os.environ, MORGAGNI_PACS_PASSWORD="geheim")
    full.update(environment or {})
    done = subprocess.run([MORGAGNI, "pacs", *map(str, arguments)], capture_output=True, text=True,
                          timeout=timeout, env=full, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout, done.stderr


class PacsCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.mkdtemp(prefix="mor_pacs_")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def setUp(self):
        self.out = os.path.join(self.scratch, self.id().split(".")[-1])

    def fails(self, text, *arguments, **more):
        """It ends with 1 and one sentence that has `text`; nothing looks finished."""
        code, out, error = run(*arguments, **more)
        self.assertEqual(code, 1, error)
        self.assertIn(text, error)
        self.assertFalse(os.path.exists(self.out))
        return out, error


class WithOrthanc(PacsCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.orthanc = Orthanc(os.path.join(cls.scratch, "orthanc"))
        cls.chest = Series(1, num_slices=NUM_SLICES)
        cls.scout = Series(2, study=cls.chest.study_uid, modality="OT", num_slices=2, number="9", description="Scout")
        cls.body = Series(4, patient_id="0042", name="Whole^Body", num_slices=60, size=112, accession="C3")
        cls.other = Series(3, patient_id="0815", name="Müller^Örs", num_slices=3, date="20250301", accession="B2")
        for series in (cls.chest, cls.scout, cls.other, cls.body):
            for data in series.files.values():
                cls.orthanc.store(data)
        cls.web = f"http://127.0.0.1:{Orthanc.HTTP_PORT}/dicom-web"
        cls.dicom = f"dicom://ORTHANC@127.0.0.1:{Orthanc.DICOM_PORT}"

    @classmethod
    def tearDownClass(cls):
        cls.orthanc.stop()
        super().tearDownClass()

    def check_whole(self, series, folder=None):
        """Each object is there, its data set as it was sent, bit for bit."""
        folder = os.path.join(folder or self.out, series.uid)
        self.assertEqual(sorted(os.listdir(folder)), sorted(uid + ".dcm" for uid in series.files))
        for uid, data in series.files.items():
            with open(os.path.join(folder, uid + ".dcm"), "rb") as file:
                self.assertEqual(dataset_of(file.read()), dataset_of(data), uid)


class Query(WithOrthanc):
    def studies(self, address, *filters):
        code, out, error = run("query", address, *USER, *filters, "--json")
        self.assertEqual(code, 0, error)
        return json.loads(out)["studies"]

    def test_finds_the_same_by_both_ways(self):
        for filters in (["--patient-name", "Doe*"], ["--patient-name", "Doe^Jane"], ["--patient-id", "4711"], ["--date", "20260101-20260228", "--patient-id", "4711"],
                        ["--accession", "A17"], ["--study", self.chest.study_uid], ["--modality", "OT"]):
            for address in (self.web, self.dicom):
                found = self.studies(address, *filters)
                self.assertEqual([study["uid"] for study in found], [self.chest.study_uid], (address, filters))
                study = found[0]
                self.assertEqual((study["patient_id"], study["patient_name"], study["date"], study["accession"]),
                                 ("4711", "Doe^Jane", "20260131", "A17"))
                series = {one["uid"]: one for one in study["series"]}
                self.assertEqual(set(series), {self.chest.uid, self.scout.uid})
                self.assertEqual(series[self.chest.uid]["modality"], "CT")
                self.assertEqual(series[self.chest.uid]["objects"], NUM_SLICES)

    def test_names_keep_their_letters(self):
        for address in (self.web, self.dicom):
            self.assertEqual(self.studies(address, "--patient-id", "0815")[0]["patient_name"], "Müller^Örs")
            self.assertEqual(len(self.studies(address, "--patient-name", "Müller*")), 1, address)

    def test_says_when_nothing_fits(self):
        for address in (self.web, self.dicom):
            code, out, error = run("query", address, *USER, "--patient-id", "nobody")
            self.assertEqual((code, out), (0, "no study fits\n"), error)

    def test_echo(self):
        for address in (self.web, self.dicom):
            code, out, error = run("query", address, *USER, "--echo")
            self.assertEqual(code, 0, error)
            self.assertIn("answers", out)


class Get(WithOrthanc):
    def ways(self):
        yield "web", [self.web, *USER]
        yield "get", [self.dicom]
        yield "move", [self.dicom, "--by", "move"]

    def test_brings_the_ct_bit_for_bit_and_names_what_is_left_out(self):
        for name, way in self.ways():
            folder = self.out + name
            code, out, error = run("get", *way, "--patient-id", "4711", "--out", folder)
            self.assertEqual(code, 0, (name, error))
            self.assertIn("left out:   9  OT", error)
            self.assertIn(f"{NUM_SLICES} objects of 1 series", out)
            self.assertEqual(os.listdir(folder), [self.chest.uid])
            self.check_whole(self.chest, folder)
            self.assertFalse(os.path.exists(folder + ".pending"))

    def test_takes_up_again_what_a_bad_line_breaks(self):
        size = sum(map(len, self.chest.files.values()))
        for name, port in (("web", Orthanc.HTTP_PORT), ("get", Orthanc.DICOM_PORT)):
            cut = 40000
            # The first connections are for questions; then one after the other breaks amid the slices.
            proxy = Proxy(port, cuts=[None, None, None, cut, cut, cut] if name == "get" else [size // 2])
            address = (f"http://127.0.0.1:{proxy.port}/dicom-web" if name == "web"
                       else f"dicom://ORTHANC@127.0.0.1:{proxy.port}")
            folder = self.out + name
            code, out, error = run("get", address, *USER, "--patient-id", "4711", "--out", folder)
            proxy.stop()
            self.assertEqual(code, 0, (name, error))
            self.assertIn("trying again", error)
            self.assertIn("taken up again", out)
            self.check_whole(self.chest, folder)
            # What was whole did not come again: but for what was under way, and the talk, nothing is twice.
            self.assertLess(proxy.num_bytes, 1.25 * size + 60000, name)
            if name == "web":
                asked = proxy.requests.count(b"/instances/")
                self.assertLess(asked, 0.75 * NUM_SLICES)
                self.assertGreater(asked, 0)

    def test_a_later_run_goes_on_where_one_ended(self):
        proxy = Proxy(Orthanc.HTTP_PORT, cut_all_after=60000)
        address = f"http://127.0.0.1:{proxy.port}/dicom-web"
        get = ["--patient-id", "4711", "--out", self.out]
        process = subprocess.Popen([MORGAGNI, "pacs", "get", address, *USER, *get], stderr=subprocess.PIPE,
                                   env=dict(os.environ, MORGAGNI_PACS_PASSWORD="geheim"))
        pending = os.path.join(self.out + ".pending", self.chest.uid)
        deadline = time.time() + 30
        while len([name for name in (os.listdir(pending) if os.path.isdir(pending) else []) if
                   name.endswith(".dcm")]) < 5 and time.time() < deadline:
            time.sleep(0.02)
        process.kill()
        process.communicate()
        proxy.stop()
        self.assertFalse(os.path.exists(self.out))
        there = len([name for name in os.listdir(pending) if name.endswith(".dcm")])
        self.assertGreaterEqual(there, 5)
        self.assertLess(there, NUM_SLICES)
        code, out, error = run("get", self.web, *USER, *get)
        self.assertEqual(code, 0, error)
        self.assertIn(f"{there} were there already", out)
        self.check_whole(self.chest)

    def test_prepares_a_case(self):
        case = self.out + "_case"
        code, out, error = run("get", self.dicom, "--patient-id", "0042", "--out", self.out, "--prepare", case)
        self.assertEqual(code, 0, error)
        self.assertTrue(os.path.exists(os.path.join(case, "case.json")))

    def test_asks_which_study(self):
        out, error = self.fails("3 studies fit", "get", self.web, *USER, "--out", self.out)
        self.assertIn("Doe^Jane", error)
        self.fails("no study fits", "get", self.web, *USER, "--patient-id", "nobody", "--out", self.out)
        self.fails("no series of MR", "get", self.dicom, "--patient-id", "0815", "--modality", "MR", "--out", self.out)

    def test_leaves_a_folder_alone_that_is_there(self):
        os.makedirs(self.out + "/mine")
        code, _, error = run("get", self.web, *USER, "--patient-id", "0815", "--out", self.out)
        self.assertEqual(code, 1)
        self.assertIn("is there already", error)
        self.assertEqual(os.listdir(self.out), ["mine"])

    def test_mixes_nothing_with_what_another_run_left(self):
        os.makedirs(self.out + ".pending/1.2.3")
        self.fails("has what another run fetched, 1.2.3", "get", self.web, *USER, "--patient-id", "0815", "--out", self.out)

    def test_keeps_its_limits(self):
        for way in (self.web, *USER), (self.dicom,):
            self.fails("--min-free-mb", "get", *way, "--patient-id", "0815", "--out", self.out,
                       "--min-free-mb", 1000000, "--tries", 1)

    def test_says_who_refuses(self):
        get = ["--patient-id", "4711", "--out", self.out]
        self.fails("Called AE Title Not Recognized", "get",
                   f"dicom://WRONG@127.0.0.1:{Orthanc.DICOM_PORT}", *get)
        # Orthanc lets anybody connect, and breaks off what a stranger asks.
        self.fails("broke the connection off", "query", self.dicom, "--aet", "STRANGER", "--patient-id", "4711")
        self.fails("401", "get", self.web, "--user", "anna", *get, environment={"MORGAGNI_PACS_PASSWORD": "wrong"})
        self.fails("not there", "get", f"http://127.0.0.1:{Orthanc.HTTP_PORT}/elsewhere", *USER, *get)

    def test_says_what_is_wrong_with_the_line(self):
        closed = socket.create_server(("127.0.0.1", 0))
        port = closed.getsockname()[1]
        silent = socket.create_server(("127.0.0.1", 0))
        mute = silent.getsockname()[1]
        closed.close()
        query = ["--timeout-s", 1, "--echo"]
        self.fails("refused", "query", f"dicom://PACS@127.0.0.1:{port}", *query)
        self.fails("refused", "query", f"http://127.0.0.1:{port}/dicom-web", *query)
        self.fails("1 s", "query", f"dicom://PACS@127.0.0.1:{mute}", *query)
        self.fails("does not answer", "query", f"http://127.0.0.1:{mute}/dicom-web", *query)
        silent.close()

    def test_password_from_a_file(self):
        file = self.out + ".password"
        with open(file, "w") as out:
            out.write("geheim\n")
        code, _, error = run("query", self.web, *USER, "--password-file", file, "--echo",
                             environment={"MORGAGNI_PACS_PASSWORD": "wrong"})
        self.assertEqual(code, 0, error)


class Tls(WithOrthanc):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.ca = make_certificate(cls.scratch, "ca")
        cls.server = make_certificate(cls.scratch, "server", cls.ca)
        cls.mine = make_certificate(cls.scratch, "mine", cls.ca)
        cls.stranger = make_certificate(cls.scratch, "stranger")

    def proxies(self, wants_ours=False, server=None):
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        key, certificate = server or self.server
        context.load_cert_chain(certificate, key)
        if wants_ours:
            context.verify_mode = ssl.CERT_REQUIRED
            context.load_verify_locations(self.ca[1])
        web, dicom = Proxy(Orthanc.HTTP_PORT, tls=context), Proxy(Orthanc.DICOM_PORT, tls=context)
        yield f"https://127.0.0.1:{web.port}/dicom-web"
        yield f"dicoms://ORTHANC@127.0.0.1:{dicom.port}"

    def test_fetches_with_the_right_certificates(self):
        for i, address in enumerate(self.proxies(wants_ours=True)):
            folder = f"{self.out}{i}"
            code, _, error = run("get", address, *USER, "--patient-id", "4711", "--out", folder, "--ca", self.ca[1],
                                 "--key", self.mine[0], "--certificate", self.mine[1])
            self.assertEqual(code, 0, (address, error))
            self.check_whole(self.chest, folder)

    def test_trusts_no_other(self):
        for address in self.proxies():
            code, _, error = run("query", address, *USER, "--echo", "--ca", self.stranger[1], "--timeout-s", 5)
            self.assertEqual(code, 1, address)
            self.assertRegex(error, "certificate is not trusted: .*--ca")
        web, dicom = self.proxies()
        self.fails("certificate is not trusted", "query", web, *USER, "--echo")
        self.fails("needs --ca", "query", dicom, "--echo")

    def test_trusts_nobody_elses_certificate_and_no_old_one(self):
        """All of the same authority."""
        for name, more, why in (("elsewhere", {"host": "DNS:elsewhere.example,IP:127.0.0.2"}, "made out to another host"),
                                ("nameless", {"host": "email:it@example.org"}, "made out to another host"),
                                ("old", {"days": -1}, "has expired")):
            for address in self.proxies(server=make_certificate(self.scratch, name, self.ca, **more)):
                _, error = self.fails("certificate is not trusted: it " + ("has" if name == "old" else "is"), "query",
                                      address, *USER, "--echo", "--ca", self.ca[1], "--timeout-s", 5)
                self.assertIn(why, error, (name, address))
                self.assertEqual(len(error.strip().splitlines()), 1, error)

    def test_is_let_in_only_with_its_own(self):
        for address in self.proxies(wants_ours=True):
            code, _, error = run("query", address, *USER, "--echo", "--ca", self.ca[1], "--timeout-s", 5)
            self.assertEqual(code, 1, address)

    def test_names_a_file_that_cannot_be_used(self):
        for address in self.proxies():
            for option, file in (("--ca", self.mine[0]), ("--ca", "/nowhere.pem")):
                self.fails(file, "query", address, *USER, "--echo", option, file)


class OrthancsOwnTls(PacsCase):
    """Orthanc with TLS at its DICOM port; it wants our certificate too."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.ca = make_certificate(cls.scratch, "ca")
        server = make_certificate(cls.scratch, "server", cls.ca)
        cls.mine = make_certificate(cls.scratch, "mine", cls.ca)
        cls.stranger = make_certificate(cls.scratch, "stranger")
        cls.orthanc = Orthanc(os.path.join(cls.scratch, "orthanc"), (*server, cls.ca[1]))
        cls.chest = Series(1, num_slices=NUM_SLICES)
        for data in cls.chest.files.values():
            cls.orthanc.store(data)

    @classmethod
    def tearDownClass(cls):
        cls.orthanc.stop()
        super().tearDownClass()

    check_whole = WithOrthanc.check_whole

    @staticmethod
    def address(host="127.0.0.1"):
        return f"dicoms://ORTHANC@{host}:{Orthanc.DICOM_PORT}"

    def ours(self, ca=None):
        return ["--ca", (ca or self.ca)[1], "--key", self.mine[0], "--certificate", self.mine[1]]

    def test_fetches_by_both_ways(self):
        for way in "get", "move":
            folder = self.out + way
            code, _, error = run("get", self.address(), "--by", way, "--patient-id", "4711", "--out", folder, *self.ours())
            self.assertEqual(code, 0, (way, error))
            self.check_whole(self.chest, folder)

    def test_is_refused_where_its_certificate_is_not_the_right_one(self):
        echo = "--echo", "--timeout-s", 5
        self.fails("--ca does not vouch for it", "query", self.address(), *echo, *self.ours(self.stranger))
        # It is made out to 127.0.0.1.
        self.fails("made out to another host", "query", self.address("localhost"), *echo, *self.ours())

    def test_lets_nobody_in_without_a_certificate(self):
        _, error = self.fails("127.0.0.1", "query", self.address(), "--echo", "--timeout-s", 5, "--ca", self.ca[1])
        self.assertEqual(len(error.strip().splitlines()), 1, error)


class HostileWebServer(PacsCase):
    def ask(self, answer, *more, timeout=60):
        server = HostileWeb(answer)
        arguments = ["get", f"http://127.0.0.1:{server.port}/dicom-web", "--timeout-s", 5, "--tries", 1, "--out", self.out, *more]
        try:
            return run(*arguments, timeout=timeout)
        finally:
            server.stop()

    def expect(self, text, answer, *more):
        code, _, error = self.ask(answer, *more)
        self.assertEqual(code, 1, error)
        self.assertIn(text, error)
        self.assertFalse(os.path.exists(self.out))

    def test_queries_that_are_none(self):
        json_type = "application/dicom+json"
        self.expect("nested", lambda h: reply(h, 200, json_type, b"[" * 200000))
        self.expect("not a list", lambda h: reply(h, 200, json_type, b'{"a": 1}'))
        self.expect("not a list", lambda h: reply(h, 200, "text/html", b"<html>login</html>"))
        self.expect("more than 32 MB", lambda h: reply(h, 200, json_type, b"[" + b" " * (40 << 20) + b"]"))
        self.expect("no study fits", lambda h: reply(h, 200, json_type, b'[{"0020000D":{"Value":["../../etc"]}}]'))
        self.expect("login.example", self.redirect)
        self.expect("500", lambda h: reply(h, 500, "text/plain", b""))

    @staticmethod
    def redirect(handler):
        handler.send_response(302)
        handler.send_header("Location", "http://login.example/?next=dicom-web")
        handler.send_header("Content-Length", "0")
        handler.end_headers()

    def catalogue(self, objects):
        """Answers queries with one study of one series of one object, and retrievals by `objects`."""
        def value(tag, text):
            return {tag: {"vr": "UI", "Value": [text]}}

        def answer(handler):
            path = handler.path.split("?")[0]
            found = {**value("0020000D", "1.2.3"), **value("0020000E", "1.2.4"), **value("00080060", "CT"),
                     **value("00080018", "1.2.5"), **value("00100010", "\x1b[2JEvil^\x07Name")}
            if path.endswith(("/studies", "/series", "/instances")):
                reply(handler, 200, "application/dicom+json", json.dumps([found]).encode())
            else:
                objects(handler)
        return answer

    def objects(self, body, content_type='multipart/related; type="application/dicom"; boundary=XX', length=None):
        return self.catalogue(lambda handler: reply(handler, 200, content_type, body, length))

    def test_objects_that_are_none(self):
        head = b"--XX\r\nContent-Type: application/dicom\r\n\r\n"
        good = part10(b"", CT_IMAGE, "1.2.5")
        self.expect("not multipart/related", self.objects(b"", "application/dicom"))
        self.expect("no boundary", self.objects(b"", "multipart/related"))
        self.expect("ended too early", self.objects(head + good))
        self.expect("no DICOM file", self.objects(head + b"MZ" * 500 + b"\r\n--XX--"))
        self.expect("proper SOP Instance UID",
                    self.objects(head + part10(b"", CT_IMAGE, "../../../x") + b"\r\n--XX--"))
        self.expect("not asked for", self.objects(head + part10(b"", CT_IMAGE, "1.2.6") + b"\r\n--XX--"))
        self.expect("has no end", self.objects(b"--XX\r\n" + b"A: b\r\n" * 5000))
        self.expect("--max-object-mb", self.objects(head + good + bytes(3 << 20) + b"\r\n--XX--"),
                    "--max-object-mb", 1)
        self.expect("does not send", self.objects(b"--XX--"))
        code, _, error = self.ask(self.objects(head + good + b"\r\n--XX--"))
        self.assertEqual(code, 0, error)
        self.assertEqual(os.listdir(self.out + "/1.2.4"), ["1.2.5.dcm"])

    def test_a_list_that_comes_in_pages_without_a_count(self):
        uids = [f"1.2.5.{number}" for number in range(1, 6)]

        def objects(handler):
            wanted = [uid for uid in uids if handler.path.endswith("/" + uid)] or uids
            body = b"".join(b"--XX\r\n\r\n" + part10(b"", CT_IMAGE, uid) + b"\r\n" for uid in wanted) + b"--XX--"
            reply(handler, 200, 'multipart/related; type="application/dicom"; boundary=XX', body)

        catalogue = self.catalogue(objects)

        def answer(handler):
            path, _, query = handler.path.partition("?")
            if not path.endswith("/instances"):
                return catalogue(handler)
            start = int(query.split("offset=")[1])
            page = [{"00080018": {"vr": "UI", "Value": [uid]}} for uid in uids[start:start + 2]]
            return reply(handler, 200, "application/dicom+json", json.dumps(page).encode())

        code, _, error = self.ask(answer)
        self.assertEqual(code, 0, error)
        self.assertEqual(sorted(os.listdir(self.out + "/1.2.4")), [uid + ".dcm" for uid in uids])

    def test_says_that_the_servers_list_goes_on_where_little_of_it_fits(self):
        names = ["Doe^Jane"] + ["Do^Other"] * 200
        found = [{"0020000D": {"vr": "UI", "Value": [f"1.2.{number}"]}, "00100010": {"vr": "PN", "Value": [name]}}
                 for number, name in enumerate(names)]
        server = HostileWeb(lambda h: reply(h, 200, "application/dicom+json", json.dumps(
            found if h.path.split("?")[0].endswith("/studies") else []).encode()))
        code, out, error = run("query", f"http://127.0.0.1:{server.port}/x", "--patient-name", "Doe^Jane")
        server.stop()
        self.assertEqual(code, 0, error)
        self.assertIn("and more than these 1:", out)

    def test_names_do_not_reach_the_terminal_as_commands(self):
        server = HostileWeb(self.objects(b""))
        code, out, error = run("query", f"http://127.0.0.1:{server.port}/x")
        server.stop()
        self.assertEqual(code, 0, error)
        self.assertIn("[2JEvil^ Name", out)
        self.assertNotIn("\x1b", out)


class HostileDicomServer(PacsCase):
    def expect(self, text, answer, *more):
        server = HostileDicom(answer)
        code, _, error = run("query", f"dicom://PACS@127.0.0.1:{server.port}", *(more or ("--timeout-s", 2)))
        server.stop()
        self.assertEqual(code, 1, error)
        self.assertIn(text, error)

    def test_answers_that_kill(self):
        pending = command(0x8020, 1, FIND, True, responds_to=1, status=0xFF00)
        # DCMTK follows nested sequences until its stack is gone: the process of the connection dies, not ours.
        self.expect("died of what it sent", lambda c, context: (
            c.sendall(data_pdu(context, True, pending) + data_pdu(context, False, nested_bomb(20000)))), "--timeout-s", 20)
        self.expect("127.0.0.1", lambda c, context: c.sendall(b"\xff" * 100000))
        self.expect("127.0.0.1", lambda c, context: c.sendall(struct.pack(">BBI", 4, 0, 0xFFFFFFF0) + b"x" * 1000))
        self.expect("127.0.0.1", lambda c, context: c.sendall(pdu(7, bytes(4))))
        self.expect("did not answer within 2 s", lambda c, context: time.sleep(4))

    def test_endless_answers_end(self):
        pending = command(0x8020, 1, FIND, True, responds_to=1, status=0xFF00)
        one = data_pdu(1, True, pending) + data_pdu(1, False, struct.pack("<HHI", 0x20, 0x0D, 6) + b"1.2.3\0")

        def answer(connection, _):
            while True:
                connection.sendall(one)

        server = HostileDicom(answer)
        code, out, error = run("query", f"dicom://PACS@127.0.0.1:{server.port}", "--timeout-s", 5)
        server.stop()
        # 200 studies are taken; of those the series are not asked for.
        self.assertEqual(code, 0, error)
        self.assertIn("more than these 200", out)


if __name__ == "__main__":
    netns.enter()
    if not shutil.which("openssl"):
        netns.skip("the program openssl is not installed")
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
