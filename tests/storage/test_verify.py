"""Whatever is changed, lost or added in the store, `verify` finds it."""

import hashlib
import os
import shutil
from pathlib import Path

import pytest
import sqlalchemy as sql

from storage.catalogue import audit_trail, database, results, runs, tables
from storage.catalogue.runs import Run
from storage.formats.content import write_columns
from storage.formats.mcap.writer import write_mcap
from storage.home import Home
from storage.verify import StoreFault, verify
from tests.keep import by_force, keep
from tests.storage.small import calibrated, certified, small


@pytest.fixture
def filled(fresh) -> Run:
    """A run in the fresh home, with a result and a certificate A-1."""
    recording = small()
    run = runs.add(recording, fresh)[0]
    keep(certified(recording, calibrated(run), "A-1"), fresh)
    return run


def replace(path: Path, content: bytes) -> None:
    path.unlink()
    path.write_bytes(content)


def only_fault(home: Home) -> StoreFault:
    (fault,) = verify(home)[1]
    return fault


def test_store_as_it_was_left_has_no_fault(fresh, filled):
    found = []
    checked, faults = verify(fresh, lambda done, total: found.append((done, total)))
    assert (checked, faults) == (10, [])
    assert found == [(n, 10) for n in range(1, 11)]


def test_raw_recording_that_is_missing_is_found(fresh, filled):
    path = fresh.raw / f"{filled.digest}.mcap"
    path.unlink()
    fault = only_fault(fresh)
    assert fault.what == str(path)
    assert "import small again" in fault.why


@pytest.mark.parametrize("where", [0.1, 0.5, 0.9])
def test_flipped_byte_in_a_raw_recording_is_found(fresh, filled, where):
    path = fresh.raw / f"{filled.digest}.mcap"
    content = bytearray(path.read_bytes())
    content[int(where * len(content))] ^= 1
    replace(path, bytes(content))
    assert only_fault(fresh).what == str(path)


def test_columns_that_were_changed_are_found_and_missing_ones_are_no_fault(fresh, filled):
    folder = fresh.columns / filled.digest
    shutil.rmtree(folder)
    assert verify(fresh) == (9, [])
    write_columns(small(start=1.0), folder)
    assert only_fault(fresh).what == str(folder)


def test_result_that_cannot_be_read_is_found(fresh, filled):
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.results).values(document="{}"))
    assert only_fault(fresh).what.startswith("result c")


def test_result_that_speaks_of_another_recording_is_found(fresh, filled):
    document = calibrated(filled, digest="0" * 64).model_dump_json()
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.results).values(document=document))
    assert "calibrate run" in only_fault(fresh).why


def test_result_whose_document_was_changed_is_found(fresh, filled):
    with database.changing(fresh) as connection:
        document = connection.scalars(sql.select(tables.results.c.document)).one()
        assert "0.25" in document
        changed = document.replace("0.25", "0.24")
        connection.execute(sql.update(tables.results).values(document=changed))
    fault = only_fault(fresh)
    assert fault.what.startswith("result c")
    assert "changed after it was kept" in fault.why


def test_certificate_that_prints_another_calibration_than_its_result_is_found(fresh, filled):
    other = results.save(calibrated(filled, 0.5), fresh)
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.certificates).values(result=other))
    fault = only_fault(fresh)
    assert fault.what == "certificate A-1"
    assert other in fault.why


def test_certificate_that_was_changed_or_lost_is_found(fresh, filled):
    pdf, record = (fresh.certificates / f"A-1{suffix}" for suffix in (".pdf", ".json"))
    replace(pdf, b"%PDF with another verdict")
    replace(record, record.read_bytes().replace(b'"pass"', b'"fail"'))
    faults = verify(fresh)[1]
    assert {fault.what for fault in faults} == {str(pdf), str(record), "certificate A-1"}
    pdf.unlink()
    record.unlink()
    assert len(verify(fresh)[1]) == 3


def test_files_that_the_catalogue_does_not_know_are_found(fresh, filled):
    misplaced = [
        fresh.raw / "stray.mcap",
        fresh.columns / "stray",
        fresh.certificates / "A-2.pdf",
    ]
    for path in misplaced:
        path.write_bytes(b"")
    # A file among the certificates may be of one that is just being issued, for a minute.
    assert [fault.what for fault in verify(fresh)[1]] == [str(path) for path in misplaced[:2]]
    os.utime(misplaced[2], (0, 0))
    assert {fault.what for fault in verify(fresh)[1]} == {str(path) for path in misplaced}


def test_draft_of_a_running_import_is_no_fault_until_it_is_old(fresh, filled):
    draft = fresh.raw / ".draft.part"
    draft.write_bytes(b"")
    assert verify(fresh)[1] == []
    os.utime(draft, (0, 0))
    assert only_fault(fresh) == StoreFault(
        what=str(draft), why="left by what was broken off; delete it"
    )


def test_store_whose_catalogue_was_lost_names_every_file(fresh, filled):
    for path in fresh.path.glob("catalog.sqlite*"):
        path.unlink()
    for path in fresh.certificates.iterdir():
        os.utime(path, (0, 0))
    assert len(verify(fresh)[1]) == 5


def test_acquisition_that_was_broken_off_is_named_with_the_way_to_take_it_in(fresh, filled):
    left = fresh.acquiring / "20261121T000000Z-0.mcap"
    left.parent.mkdir()
    write_mcap(small(), left)
    assert verify(fresh)[1] == []  # it may still be running
    os.utime(left, (0, 0))
    fault = only_fault(fresh)
    assert fault.what == str(left)
    assert "mimucal import --salvage" in fault.why


def test_a_trail_that_was_changed_is_found(fresh, filled):
    by_force(fresh, sql.update(tables.trail).values(person="another"))
    fault = only_fault(fresh)
    assert fault.what == "trail"
    assert "entry 1 was changed" in fault.why


def test_a_certificate_that_left_the_register_is_found(fresh, filled):
    with database.changing(fresh) as connection:
        connection.execute(sql.delete(tables.certificates))
    assert "A-1 is issued in the trail and is not in the register" in only_fault(fresh).why


def test_a_file_changed_together_with_its_hash_is_found(fresh, filled):
    pdf = fresh.certificates / "A-1.pdf"
    replace(pdf, b"%PDF with another verdict")
    forged = hashlib.sha256(pdf.read_bytes()).hexdigest()
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.certificates).values(pdf_sha256=forged))
    assert "A-1 has other files in the register than in the trail" in only_fault(fresh).why


def test_a_certificate_that_the_trail_does_not_know_is_found(fresh, filled):
    end = sql.update(tables.trail_end).values(number=0, hash=audit_trail.NOTHING_BEFORE)
    by_force(fresh, sql.delete(tables.trail), end)
    assert "A-1 is in the register, and the trail does not know it" in only_fault(fresh).why


def test_a_raw_recording_that_is_cut_off_is_named_once_with_one_way_out(fresh, filled):
    path = fresh.raw / f"{filled.digest}.mcap"
    content = path.read_bytes()
    replace(path, content[: len(content) * 3 // 4])
    fault = only_fault(fresh)
    assert fault.what == str(path)
    assert str(path) not in fault.why
    assert "or, where there is no source any more," in fault.why
    assert "samples up to" in fault.why
