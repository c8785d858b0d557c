"""A small S3 server on this machine, which may answer 500 now and then, and slowly."""

import re
import socket
import sys
import threading
import time
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager, suppress
from hashlib import md5
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from itertools import count
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape, unescape

FAULT = b"<Error><Code>InternalError</Code><Message>planted</Message></Error>"


class Store:
    """Objects by key. every: each so-manieth request is answered with 500, none for 0."""

    def __init__(self, every: int = 0, pause_s: float = 0.0) -> None:
        self.objects: MutableMapping[str, bytes] = {}
        self.parts: dict[str, dict[int, bytes]] = {}
        self.requests = count(1)
        self.faults = 0
        self.every = every
        self.pause_s = pause_s


class Handler(BaseHTTPRequestHandler):
    """What pyarrow asks of S3: objects whole and in parts, their heads, and listings."""

    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    store: Store

    def log_message(self, *_: object) -> None:
        """Quiet."""

    def do_HEAD(self) -> None:
        self._serve(self._get)

    def do_GET(self) -> None:
        self._serve(self._get)

    def do_PUT(self) -> None:
        self._serve(self._put)

    def do_POST(self) -> None:
        self._serve(self._post)

    def do_DELETE(self) -> None:
        self._serve(self._delete)

    def _serve(self, answer: Any) -> None:
        parts = urlsplit(self.path)
        self.key = unquote(parts.path).lstrip("/")
        self.asked = {k: v[0] for k, v in parse_qs(parts.query, keep_blank_values=True).items()}
        self.body = self._read_body()
        time.sleep(self.store.pause_s)
        if self.store.every and next(self.store.requests) % self.store.every == 0:
            self.store.faults += 1
            self._answer(500, FAULT)
            return
        answer()

    def _read_body(self) -> bytes:
        """The body out of HTTP's chunks, and out of those of AWS within them."""
        if "chunked" in (self.headers.get("Transfer-Encoding") or ""):
            body = b""
            while size := int(self.rfile.readline(), 16):
                body += self.rfile.read(size)
                self.rfile.readline()
            self.rfile.readline()
        else:
            body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        if "aws-chunked" not in (self.headers.get("Content-Encoding") or ""):
            return body
        whole, rest = b"", body
        while size := int(rest.partition(b"\r\n")[0].split(b";")[0], 16):
            rest = rest.partition(b"\r\n")[2]
            whole, rest = whole + rest[:size], rest[size + 2 :]
        return whole

    def _answer(self, code: int, body: bytes = b"", **headers: str) -> None:
        self.send_response(code)
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), value)
        if "Content_Length" not in headers:
            self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _get(self) -> None:
        if "list-type" in self.asked:
            self._list()
            return
        data = self.store.objects.get(self.key)
        if data is None:
            self._answer(200 if "/" not in self.key else 404)
            return
        about = {"ETag": f'"{md5(data).hexdigest()}"', "Last_Modified": self.date_time_string()}
        ranged = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range") or "")
        if ranged and self.command == "GET":
            first, last = int(ranged[1]), int(ranged[2] or len(data) - 1)
            of = f"bytes {first}-{min(last, len(data) - 1)}/{len(data)}"
            self._answer(206, data[first : last + 1], Content_Range=of, **about)
            return
        self._answer(200, data, Content_Length=str(len(data)), **about)

    def _list(self) -> None:
        bucket, prefix = self.key.strip("/"), self.asked.get("prefix", "")
        found = self._keys(f"{bucket}/{prefix}")
        rows = "".join(
            f"<Contents><Key>{escape(k.split('/', 1)[1])}</Key><Size>{len(self.store.objects[k])}"
            "</Size><LastModified>2026-01-01T00:00:00.000Z</LastModified></Contents>"
            for k in found
        )
        body = f"<ListBucketResult><KeyCount>{len(found)}</KeyCount>{rows}</ListBucketResult>"
        self._answer(200, body.encode(), Content_Type="application/xml")

    def _keys(self, prefix: str) -> list[str]:
        return sorted(key for key in self.store.objects if key.startswith(prefix))

    def _put(self) -> None:
        if "partNumber" in self.asked:
            self.store.parts[self.asked["uploadId"]][int(self.asked["partNumber"])] = self.body
        else:
            self.store.objects[self.key] = self.body
        self._answer(200, ETag=f'"{md5(self.body).hexdigest()}"')

    def _post(self) -> None:
        if "uploads" in self.asked:
            upload = f"u{len(self.store.parts)}"
            self.store.parts[upload] = {}
            text = f"<UploadId>{upload}</UploadId>"
            kind = "InitiateMultipartUploadResult"
        elif "delete" in self.asked:
            for key in re.findall(r"<Key>(.*?)</Key>", self.body.decode()):
                self.store.objects.pop(f"{self.key.strip('/')}/{unescape(key)}", None)
            kind, text = "DeleteResult", ""
        else:
            parts = self.store.parts[self.asked["uploadId"]]
            self.store.objects[self.key] = b"".join(parts[k] for k in sorted(parts))
            kind, text = "CompleteMultipartUploadResult", '<ETag>"whole"</ETag>'
        body = f"<{kind}><Key>{escape(self.key)}</Key>{text}</{kind}>"
        self._answer(200, body.encode(), Content_Type="application/xml")

    def _delete(self) -> None:
        self.store.objects.pop(self.key, None)
        self._answer(204)


class Server(ThreadingHTTPServer):
    """One whose connections end with it: a client keeps them open, and would be served on."""

    def __init__(self, handler: type[Handler], port: int) -> None:
        super().__init__(("127.0.0.1", port), handler)
        self.lines: list[socket.socket] = []

    def process_request(self, request: Any, client_address: Any) -> None:
        self.lines.append(request)
        super().process_request(request, client_address)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that was killed is no fault of the server."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    def hang_up(self) -> None:
        for line in self.lines:
            with suppress(OSError):  # the client was first
                line.shutdown(socket.SHUT_RDWR)


@contextmanager
def serving(store: Store, kind: type[Handler] = Handler, port: int = 0) -> Iterator[str]:
    """Serves a store on a port, any free one for 0; gives what MIMUCAL_STORE is to be."""
    handler = type("StoreHandler", (kind,), {"store": store})
    server = Server(handler, port)
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    try:
        yield f"s3://lab/mimu?endpoint=127.0.0.1:{server.server_address[1]}&scheme=http&region=here"
    finally:
        server.shutdown()
        server.hang_up()
        server.server_close()
        thread.join()
