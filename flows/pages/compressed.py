"""Compresses answers with gzip for clients that accept it, such as tablets on a slow network."""

import gzip
from functools import lru_cache

from flask import Flask, request
from flask import Response as FlaskResponse

KINDS = ("text/javascript", "application/javascript", "application/json")
LEAST = 2_000  # smallest answer worth compressing, bytes
SCRIPTS = 32  # compressed scripts kept in memory
QUICK = 1  # level, for what is compressed anew each time


def compress(server: Flask) -> None:
    """Compresses scripts, once each, and JSON."""

    @server.after_request
    def smaller(response: FlaskResponse) -> FlaskResponse:
        if response.mimetype not in KINDS or response.status_code != 200:
            return response
        response.vary.add("Accept-Encoding")
        is_file = response.is_streamed or response.direct_passthrough
        if is_file or "gzip" not in request.accept_encodings:
            return response
        content = response.get_data()
        if len(content) >= LEAST:
            is_json = response.mimetype == "application/json"
            response.set_data(gzip.compress(content, QUICK) if is_json else _script(content))
            response.content_encoding = "gzip"
        return response


@lru_cache(SCRIPTS)
def _script(content: bytes) -> bytes:
    return gzip.compress(content)
