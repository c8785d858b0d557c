"""Processes that issue certificates.

They come from a server without threads: the typesetter's, which a fork would leave behind, would
be waited for without end.
"""

import os
from collections.abc import Sequence
from multiprocessing import get_context
from typing import Any

from storage.home import Home
from tasks.stages.issue import issue

ISSUER = "Zhao"
PRELOADED = ["tests.proof.issue.workers", "typst", "pylopdf_fonts_zh_cn", "psycopg"]

SERVER = get_context("forkserver")
SERVER.set_forkserver_preload(PRELOADED)


def issuing(home: Home, keys: Sequence[str], begins: Any) -> Any:
    """A process, not started, that waits at a barrier and then issues one after the other."""
    database = os.environ.get("MIMUCAL_DATABASE", "")
    return SERVER.Process(target=_issue_all, args=(home, keys, begins, database), daemon=True)


def _issue_all(home: Home, keys: Sequence[str], begins: Any, database: str) -> None:
    os.environ["MIMUCAL_DATABASE"] = database
    begins.wait()
    for key in keys:
        issue(key, home, ISSUER)
