# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause
"""TCP through a middleman that counts, cuts, and speaks TLS to whoever calls."""

import socket
import threading


class Proxy:
    """@param cuts  After so many bytes from the server each connection in turn is cut; then none.
    @param tls  Context to serve callers with."""

    def __init__(self, target_port, cuts=(), tls=None, cut_all_after=None):
        self.target_port, self.cuts, self.tls, self.cut_all_after = target_port, list(cuts), tls, cut_all_after
        self.num_bytes = 0
        self.num_connections = 0
        self.requests = b""
        self.lock = threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                caller, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(caller,), daemon=True).start()

    def _serve(self, caller):
        try:
            if self.tls:
                caller = self.tls.wrap_socket(caller, server_side=True)
            server = socket.create_connection(("127.0.0.1", self.target_port))
        except OSError:
            caller.close()
            return
        with self.lock:
            self.num_connections += 1
            limit = self.cuts.pop(0) if self.cuts else self.cut_all_after
        for end in (caller, server):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        threading.Thread(target=self._up, args=(caller, server), daemon=True).start()
        self._down(server, caller, limit)

    def _up(self, caller, server):
        try:
            while data := caller.recv(65536):
                with self.lock:
                    self.requests += data[:2048]
                server.sendall(data)
        except OSError:
            pass
        self._close(caller, server)

    def _down(self, server, caller, limit):
        passed = 0
        try:
            while data := server.recv(65536):
                if limit is not None:
                    data = data[:max(0, limit - passed)]
                caller.sendall(data)
                passed += len(data)
                with self.lock:
                    self.num_bytes += len(data)
                if limit is not None and passed >= limit:
                    break
        except OSError:
            pass
        self._close(caller, server)

    @staticmethod
    def _close(*ends):
        for end in ends:
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            end.close()

    def stop(self):
        self.listener.close()
