# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""Peers that mean ill: a DICOMweb server and a DICOM association, by hand."""

import socket
import struct
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

IMPLICIT_LITTLE = "1.2.840.10008.1.2"


class HostileWeb:
    """@param answer  Called with the handler for each GET; writes whatever it likes."""

    def __init__(self, answer):
        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                try:
                    answer(self)
                except OSError:
                    pass
                self.close_connection = True

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.port = self.server.server_address[1]
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def stop(self):
        self.server.shutdown()
        self.server.server_close()


def reply(handler, status, content_type, body, length=None):
    handler.send_response(status)
    handler.send_header("Content-Type", content_type)
    handler.send_header("Content-Length", str(len(body) if length is None else length))
    handler.end_headers()
    handler.wfile.write(body)


def pdu(kind, body):
    return struct.pack(">BBI", kind, 0, len(body)) + body


def item(kind, body):
    return struct.pack(">BBH", kind, 0, len(body)) + body


def data_pdu(context, is_command, payload):
    pieces = b""
    step = 16000
    for start in range(0, len(payload), step):
        chunk = payload[start:start + step]
        last = start + step >= len(payload)
        flags = (1 if is_command else 0) | (2 if last else 0)
        pieces += pdu(4, struct.pack(">I", len(chunk) + 2) + bytes([context, flags]) + chunk)
    return pieces


def implicit(group, number, value):
    if len(value) % 2:
        value += b"\0"
    return struct.pack("<HHI", group, number, len(value)) + value


def command(field, message_id, sop_class, has_data, responds_to=None, status=None, uid=None):
    body = implicit(0, 2, sop_class.encode()) + implicit(0, 0x100, struct.pack("<H", field))
    if responds_to is None:
        body += implicit(0, 0x110, struct.pack("<H", message_id)) + implicit(0, 0x700, struct.pack("<H", 0))
    else:
        body += implicit(0, 0x120, struct.pack("<H", responds_to))
    body += implicit(0, 0x800, struct.pack("<H", 0 if has_data else 0x0101))
    if status is not None:
        body += implicit(0, 0x900, struct.pack("<H", status))
    if uid is not None:
        body += implicit(0, 0x1000, uid.encode())
    return implicit(0, 0, struct.pack("<I", len(body))) + body


def nested_bomb(depth):
    """Sequences of undefined length in each other: (0008,1115) and an item, again and again."""
    return (struct.pack("<HHI", 8, 0x1115, 0xFFFFFFFF) + struct.pack("<HHI", 0xFFFE, 0xE000, 0xFFFFFFFF)) * depth


def associate_request(called, calling, abstract_syntax, transfer_syntax=IMPLICIT_LITTLE):
    context = item(0x20, bytes([1, 0, 0, 0]) + item(0x30, abstract_syntax.encode()) +
                   item(0x40, transfer_syntax.encode()))
    user = item(0x50, item(0x51, struct.pack(">I", 16384)) + item(0x52, b"1.2.3.4"))
    return pdu(1, struct.pack(">HH", 1, 0) + called.ljust(16).encode() + calling.ljust(16).encode() + bytes(32) +
               item(0x10, b"1.2.840.10008.3.1.1.1") + context + user)


def read_pdu(connection):
    head = b""
    while len(head) < 6:
        more = connection.recv(6 - len(head))
        if not more:
            return None, b""
        head += more
    kind, _, length = struct.unpack(">BBI", head)
    body = b""
    while len(body) < length:
        more = connection.recv(length - len(body))
        if not more:
            break
        body += more
    return kind, body


class HostileDicom:
    """Accepts any association, in its first context, and answers the first request by `answer(connection, context)`."""

    def __init__(self, answer):
        self.answer = answer
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        try:
            _, request = read_pdu(connection)
            contexts, at = b"", 68
            first = None
            while at + 4 <= len(request):
                kind, _, length = struct.unpack_from(">BBH", request, at)
                if kind == 0x20:
                    number = request[at + 4]
                    first = first or number
                    result = 0 if number == first else 3
                    contexts += item(0x21, bytes([number, 0, result, 0]) + item(0x40, IMPLICIT_LITTLE.encode()))
                at += 4 + length
            user = item(0x50, item(0x51, struct.pack(">I", 16384)) + item(0x52, b"1.2.3.4"))
            connection.sendall(pdu(2, request[:68] + item(0x10, b"1.2.840.10008.3.1.1.1") + contexts + user))
            read_pdu(connection)
            self.answer(connection, first)
            # Closed at once, what was said could be lost with what was not heard.
            connection.settimeout(20)
            while connection.recv(65536):
                pass
        except OSError:
            pass
        finally:
            connection.close()

    def stop(self):
        self.listener.close()
