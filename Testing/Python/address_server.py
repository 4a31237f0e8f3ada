# SPDX-License-Identifier: BSD-3-Clause
"""A server of a folder by HTTP, for tests of addresses: with ranges, versions of files, buckets of S3 whose
requests must be signed, slowness, and faults. It counts what it is asked for."""

import datetime
import email.utils
import hashlib
import hmac
import http.server
import os
import re
import socket
import socketserver
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse

KEY, SECRET = "AKTEST", "a/secret+key"


class Server(http.server.ThreadingHTTPServer):
    """Serves `folder` until it is closed. A fault stands for the answer to each path that its pattern is
    found in: a function of the handler and the path of the file, which returns whether it has answered."""

    daemon_threads = True
    request_queue_size = 64

    def __init__(self, folder, latency=0.0, keys=None, token=None, lists=True):
        super().__init__(("127.0.0.1", 0), Handler)
        self.folder, self.latency, self.keys, self.token, self.lists = folder, latency, keys, token, lists
        self.faults, self.gives_ranges, self.tags = {}, True, True
        self.requests, self.sent, self.lock, self.connections = [], 0, threading.Lock(), []
        self.proxied = 0  # requests for other hosts, as a proxy gets them; the folder answers these, too
        threading.Thread(target=self.serve_forever, args=(0.05,), daemon=True).start()

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server_port}"

    def forget(self):
        self.requests, self.sent = [], 0

    def handle_error(self, request, client_address):
        """A client that goes away is none."""

    def close(self):
        self.shutdown()
        for connection in self.connections:
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self.server_close()


class Relay(socketserver.ThreadingTCPServer):
    """Passes connections on to a server. Its first `bad` ones break, or go silent, amid an answer."""

    daemon_threads = True
    request_queue_size = 64

    def __init__(self, port, bad, is_silent):
        super().__init__(("127.0.0.1", 0), RelayHandler)
        self.port, self.bad, self.is_silent, self.connections, self.spoilt = port, bad, is_silent, 0, 0
        threading.Thread(target=self.serve_forever, args=(0.05,), daemon=True).start()

    def close(self):
        self.shutdown()
        self.server_close()


class RelayHandler(socketserver.BaseRequestHandler):
    def handle(self):
        self.server.connections += 1
        left = 3000 if self.server.connections <= self.server.bad else 1 << 60
        with socket.create_connection(("127.0.0.1", self.server.port)) as far:
            threading.Thread(target=self.pass_on, args=(self.request, far), daemon=True).start()
            while left > 0 and (data := far.recv(min(left, 65536))):
                self.request.sendall(data)
                left -= len(data)
            if left == 0:
                self.server.spoilt += 1
                time.sleep(3 if self.server.is_silent else 0)

    @staticmethod
    def pass_on(near, far):
        try:
            while data := near.recv(65536):
                far.sendall(data)
        except OSError:
            pass  # the other side has ended


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True

    def setup(self):
        super().setup()
        self.server.connections.append(self.connection)

    def log_message(self, *_):
        pass

    def answer(self, code, body=b"", **headers):
        with self.server.lock:
            self.server.sent += len(body)
            self.request_line[2] = code
        self.send_response(code)
        for name, value in {"Content-Length": str(len(body)), **headers}.items():
            if value is not None:
                self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self):
        path = re.sub("^http://[^/]*", "", urllib.parse.unquote(self.path))
        asked = self.headers.get("Range")
        with self.server.lock:
            self.request_line = [path, asked, None]
            self.server.requests.append(self.request_line)
            self.server.proxied += self.path.startswith("http://")
        time.sleep(self.server.latency)
        file = self.server.folder + path
        for pattern, fault in self.server.faults.items():
            if re.search(pattern, path) and fault(self, file):
                return
        if self.server.keys and not self.is_signed():
            self.deny("SignatureDoesNotMatch" if self.headers.get("Authorization") else "AccessDenied")
        elif not os.path.isfile(file):
            if self.server.lists:
                self.answer(404, b"<Error><Code>NoSuchKey</Code></Error>")
            else:
                self.deny("AccessDenied")
        else:
            self.send_file(file, asked)

    def deny(self, code):
        self.answer(403, f"<Error><Code>{code}</Code></Error>".encode(), Content_Type="application/xml")

    def send_file(self, file, asked):
        size, when = os.stat(file).st_size, os.stat(file).st_mtime_ns
        headers = {"Content_Type": "application/octet-stream"}
        if self.server.tags:
            headers["ETag"] = f'"{when:x}-{size:x}"'
            headers["Last_Modified"] = email.utils.formatdate(when / 1e9, usegmt=True)
            if self.headers.get("If-None-Match") == headers["ETag"]:
                return self.answer(304, Content_Length=None, **headers)
        match = re.fullmatch(r"bytes=(\d*)-(\d*)", asked or "")
        if not match or not self.server.gives_ranges:
            return self.answer(200, self.read(file, 0, size), **headers)
        first, last = match.groups()
        begin = int(first) if first else max(0, size - int(last))
        end = min(size, int(last) + 1) if first and last else size
        if begin >= end:
            return self.answer(416, Content_Range=f"bytes */{size}")
        headers["Content_Range"] = f"bytes {begin}-{end - 1}/{size}"
        return self.answer(206, self.read(file, begin, end), **headers)

    @staticmethod
    def read(file, begin, end):
        with open(file, "rb") as opened:
            opened.seek(begin)
            return opened.read(end - begin)

    def is_signed(self):
        """Whether the request has the signature, version 4, of the server's key. Source: Amazon's "Signature
        Version 4 signing process"."""
        match = re.fullmatch(
            r"AWS4-HMAC-SHA256 Credential=([^/]+)/(\d{8})/([^/]+)/s3/aws4_request, ?"
            r"SignedHeaders=([^,]+), ?Signature=([0-9a-f]{64})",
            self.headers.get("Authorization", ""),
        )
        if not match or match[1] != KEY:
            return False
        _, day, region, names, signature = match.groups()
        when = self.headers["x-amz-date"]
        now = datetime.datetime.now(datetime.timezone.utc).replace(tzinfo=None)
        if abs(datetime.datetime.strptime(when, "%Y%m%dT%H%M%SZ") - now) > datetime.timedelta(minutes=15):
            return False
        if self.server.token != self.headers.get("x-amz-security-token"):
            return False
        lines = "".join(f"{name}:{' '.join(self.headers[name].split())}\n" for name in names.split(";"))
        payload = self.headers.get("x-amz-content-sha256", hashlib.sha256(b"").hexdigest())
        path, _, query = self.path.partition("?")
        request = f"GET\n{path}\n{query}\n{lines}\n{names}\n{payload}"
        scope = f"{day}/{region}/s3/aws4_request"
        text = f"AWS4-HMAC-SHA256\n{when}\n{scope}\n{hashlib.sha256(request.encode()).hexdigest()}"
        key = ("AWS4" + SECRET).encode()
        for part in (day, region, "s3", "aws4_request"):
            key = hmac.new(key, part.encode(), "sha256").digest()
        return hmac.compare_digest(hmac.new(key, text.encode(), "sha256").hexdigest(), signature)


if __name__ == "__main__":
    if len(sys.argv) == 2:
        print(Server(sys.argv[1]).url, flush=True)
        sys.stdin.read()  # until whoever started it ends, or closes it
    else:  # FOLDER COMMAND...: for a program whose proxy it is, with an empty cache
        with tempfile.TemporaryDirectory() as cache:
            given = {"http_proxy": Server(sys.argv[1], latency=0.02).url, "SCALABLE_ISOSURFACE_CACHE": cache}
            sys.exit(subprocess.call(sys.argv[2:], env={**os.environ, **given, "AWS_SECRET_ACCESS_KEY": SECRET}))
