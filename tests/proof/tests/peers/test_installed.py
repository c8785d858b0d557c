"""Without their libraries the peers are left out, and the way to them is told."""

import subprocess
import sys

import pytest

from tests.proof.peers import installed

LOADS = """
import sys
import tests.proof.peers.installed, tests.proof.peers.page
print([name for name in ("sklearn", "pysindy") if name in sys.modules])
"""


def test_scoring_and_printing_need_none_of_the_libraries() -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADS], capture_output=True, text=True, timeout=600, check=True
    )
    assert done.stdout.strip() == "[]"


def test_missing_library_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert installed.peers_installed()
    monkeypatch.setattr(installed, "find_spec", lambda name: None)
    assert not installed.peers_installed()
    assert ".[peers]" in installed.MISSING.en
