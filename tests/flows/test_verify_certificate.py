"""`mimucal verify` of a certificate's file: nothing but the file, and no home."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "tasks" / "certificate"))
from tasks.certificate.pdf import faces_of
from tests.tasks.certificate.sample_certificate import certificate


@pytest.fixture
def dcc(tmp_path: Path) -> Path:
    path = tmp_path / "MIMU-2026-0042.xml"
    path.write_bytes(faces_of(certificate(), None).dcc)
    return path


def test_a_whole_file_says_what_it_is_and_what_it_cannot_know(mimucal, home, dcc) -> None:
    done = mimucal("verify", dcc)
    assert done.code == 0
    assert "whole; certificate MIMU-2026-0042, issued" in done.out
    assert "not signed electronically" in done.out
    assert not home.exists()


def test_a_changed_file_is_a_fault_in_the_published_format(mimucal, dcc) -> None:
    dcc.write_bytes(dcc.read_bytes().replace(b"0.01187", b"0.01188"))
    done = mimucal("verify", dcc, "--json")
    assert done.code == 1
    assert done.json["format"] == "mimu-verify/1"
    assert [fault["what"] for fault in done.json["faults"]] == [str(dcc)]


def test_a_file_that_is_not_there_or_certificates_that_are_none_are_one_sentence(
    mimucal, dcc
) -> None:
    for arguments, says in (
        ((dcc.with_name("none.pdf"),), "none.pdf cannot be read"),
        ((dcc, "--trust", dcc), "give a file with certificates as PEM"),
    ):
        done = mimucal("verify", *arguments)
        assert (done.code, done.out) == (2, "")
        assert says in done.err
        assert done.err.strip().count("\n") == 0
