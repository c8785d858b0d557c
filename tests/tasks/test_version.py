"""A result names the text that made it: every source, procedure and layout, and the numerics."""

from importlib.metadata import version

import pytest

from tasks.version import code_version, source_digest


def test_code_version_names_release_digest_and_numerics():
    release, *libraries = code_version().split(" ", 1)
    assert release.startswith(f"{version('mimucal')}+")
    assert libraries == [f"numpy {version('numpy')} scipy {version('scipy')}"]


@pytest.mark.parametrize("suffix", [".py", ".toml", ".typ"])
def test_another_text_is_another_digest(tmp_path, suffix):
    source = tmp_path / "tasks" / "deep" / f"source{suffix}"
    source.parent.mkdir(parents=True)
    source.write_text("1")
    before = source_digest(tmp_path)
    source.write_text("2")
    assert source_digest(tmp_path) != before
