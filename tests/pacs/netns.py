# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""A network of its own for a test: Orthanc listens everywhere by default, and nobody else is to see it."""

import array
import fcntl
import os
import shutil
import socket
import struct
import subprocess
import sys

SKIPPED = 77
INSIDE = "MORGAGNI_TEST_NETNS"


def skip(why):
    print(f"SKIPPED: {why}")
    sys.exit(SKIPPED)


def lift_loopback():
    """`ip link set lo up`, without the program."""
    up, set_flags = 0x1, 0x8914
    with socket.socket() as any_socket:
        fcntl.ioctl(any_socket, set_flags, array.array("B", struct.pack("16sh14x", b"lo", up)))


def enter():
    """Starts this program again in its own network namespace, or skips and says why."""
    if os.environ.get(INSIDE):
        lift_loopback()
        return
    unshare = shutil.which("unshare")
    if not unshare:
        skip("the program unshare is not installed (package util-linux)")
    # As root plainly; else as root of a user namespace, which some systems forbid.
    for flags in (["-n"], ["-rn"]):
        if subprocess.run([unshare, *flags, "true"], capture_output=True).returncode == 0:
            environment = dict(os.environ, **{INSIDE: "1"})
            os.execvpe(unshare, [unshare, *flags, sys.executable, *sys.argv], environment)
    skip("neither root nor a user namespace (kernel.unprivileged_userns_clone): no network of our own")
