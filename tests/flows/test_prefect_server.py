"""A server of a command's own, where it cannot start."""

import sys
from pathlib import Path

import pytest

from flows import prefect_server
from schemas.base import Unusable


def test_a_server_that_ends_at_once_is_one_sentence_with_its_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("PREFECT_API_URL", "PREFECT_HOME"):  # what is set meanwhile goes with the test
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(Unusable, match=r"see .*server\.log.*PREFECT_API_URL"):
        prefect_server._start(tmp_path)
