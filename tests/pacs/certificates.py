# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""Certificates for tests of TLS, made by openssl."""

import os
import subprocess


def make_certificate(folder, name, issuer=None, host="IP:127.0.0.1", days=2):
    """A key and a certificate for a host; signed by `issuer` or by itself."""
    key, certificate = os.path.join(folder, name + ".key"), os.path.join(folder, name + ".pem")
    if not issuer:
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", str(days), "-subj", "/CN=" + name,
                        "-addext", "subjectAltName=" + host, "-keyout", key, "-out", certificate], check=True, capture_output=True)
        return key, certificate
    request, extensions = os.path.join(folder, name + ".csr"), os.path.join(folder, name + ".ext")
    with open(extensions, "w") as file:
        file.write(f"subjectAltName={host}\nbasicConstraints=critical,CA:FALSE\n")
    subprocess.run(["openssl", "req", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=" + name, "-keyout", key, "-out", request],
                   check=True, capture_output=True)
    subprocess.run(["openssl", "x509", "-req", "-in", request, "-CA", issuer[1], "-CAkey", issuer[0], "-CAcreateserial",
                    "-days", str(days), "-extfile", extensions, "-out", certificate], check=True, capture_output=True)
    return key, certificate
