# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""A real Orthanc for a test, in the network namespace that netns.enter() made."""

import json
import os
import shutil
import subprocess
import time
import urllib.request

from netns import skip

PLUGIN = "/usr/share/orthanc/plugins/libOrthancDicomWeb.so"


class Orthanc:
    HTTP_PORT, DICOM_PORT, MOVE_PORT = 8042, 4242, 11112

    def __init__(self, folder, tls=None):
        """tls: (key, certificate, the authority that must vouch for who calls by DICOM); without: none."""
        program = shutil.which("Orthanc") or shutil.which("Orthanc", path="/usr/sbin")
        if not program or not os.path.exists(PLUGIN):
            skip("Orthanc is not installed (packages orthanc and orthanc-dicomweb)")
        os.makedirs(folder)
        config = {
            "Name": "test", "StorageDirectory": folder, "IndexDirectory": folder,
            "HttpPort": self.HTTP_PORT, "DicomPort": self.DICOM_PORT, "DicomAet": "ORTHANC",
            "DicomCheckCalledAet": True, "DicomCheckModalityHost": False, "RemoteAccessAllowed": True,
            "AuthenticationEnabled": True, "RegisteredUsers": {"anna": "geheim"},
            "DicomAlwaysAllowFind": False, "DicomAlwaysAllowGet": False, "DicomAlwaysAllowMove": False,
            "DicomAlwaysAllowEcho": False, "SynchronousCMove": True, "DefaultEncoding": "Utf8",
            "DicomModalities": {"morgagni": ["MORGAGNI", "127.0.0.1", self.MOVE_PORT]},
            "Plugins": [PLUGIN], "DicomWeb": {"Enable": True, "Root": "/dicom-web/"},
        }
        if tls:
            key, certificate, authority = tls
            config.update({
                # At the DICOM port alone: by https Debian's Orthanc 1.10 dies of the first request (signal 11).
                "DicomTlsEnabled": True, "DicomTlsCertificate": certificate, "DicomTlsPrivateKey": key,
                "DicomTlsTrustedCertificates": authority, "DicomTlsRemoteCertificateRequired": True,
                "DicomModalities": {"morgagni": {"AET": "MORGAGNI", "Host": "127.0.0.1", "Port": self.MOVE_PORT,
                                                 "UseDicomTls": True}},
            })
        file = folder + ".json"
        with open(file, "w") as out:
            json.dump(config, out)
        self.log = open(folder + ".log", "w")
        environment = dict(os.environ, TCP_NODELAY="1")
        self.process = subprocess.Popen([program, file], stdout=self.log, stderr=subprocess.STDOUT, env=environment)
        self._wait()

    def _request(self, path, data=None):
        request = urllib.request.Request(f"http://127.0.0.1:{self.HTTP_PORT}{path}", data=data)
        request.add_header("Authorization", "Basic YW5uYTpnZWhlaW0=")  # anna:geheim
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)

    def _wait(self):
        for _ in range(300):
            try:
                self._request("/system")
                return
            except OSError:
                if self.process.poll() is not None:
                    raise RuntimeError(f"Orthanc ended: see {self.log.name}")
                time.sleep(0.2)
        raise RuntimeError(f"Orthanc does not answer: see {self.log.name}")

    def store(self, file_bytes):
        self._request("/instances", file_bytes)

    def stop(self):
        self.process.terminate()
        self.process.wait(30)
        self.log.close()
