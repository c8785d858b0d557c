"""A table's own DCC becomes the rows of its errors: by list, by single numbers, in either unit."""

import math
import os
from pathlib import Path

import pytest
from lxml import etree

from schemas.base import Unusable
from storage.formats.standard_dcc import read_standard
from tests.table_dcc import ANGLES, RATES, document

SCHEMAS = Path(os.environ.get("MIMUCAL_DCC_SCHEMA", "../shared/dcc"))


@pytest.fixture
def made(tmp_path):
    def write(*results: str) -> Path:
        path = tmp_path / "dcc.xml"
        path.write_text(document(*results), encoding="utf-8")
        return path

    return write


def test_a_dcc_fills_the_table_of_its_standard(made):
    standard = read_standard(made(RATES, ANGLES), "corrected")
    assert (standard.name, standard.name_zh, standard.serial, standard.certificate) == (
        "Rate table", "转台", "TT-07", "CNAS 2026-117",
    )  # fmt: skip
    assert str(standard.calibrated_on) == "2026-03-01"
    slow, fast = standard.functions["rate"].rows
    # Relative to what the table really turned at: 10 − 0.001 °/s.
    assert (slow.at, slow.deviation) == (10.0, pytest.approx(1e-3 / 9.999))
    assert pytest.approx(2e-4 / 9.999) == slow.U
    # Both directions at 100 °/s: −2e-5 and −4e-5, each ± 1e-5.
    assert (fast.at, fast.deviation) == (100.0, pytest.approx(-3e-5, rel=1e-3))
    assert pytest.approx(2e-5, rel=1e-3) == fast.U
    position = standard.functions["position"]
    assert [row.at for row in position.rows] == [0.0, 90.0, 360.0]
    assert position.rows[1].deviation == pytest.approx(math.radians(2.5 / 3600))
    assert pytest.approx(math.radians(1.5 / 3600)) == position.rows[1].U


def test_results_of_one_kind_are_those_of_the_axes_they_name(made):
    outer = RATES.replace("inner", "outer")
    standard = read_standard(made(RATES, outer), "budgeted")
    assert standard.functions["rate"].axes == ("inner", "outer")
    assert standard.functions["rate"].deviation == "budgeted"


@pytest.mark.parametrize(
    ("results", "sentence"),
    [
        ([], "no result has both basic_nominalValue"),
        ([RATES.replace("10 100 -100", "10 100")], "has 2 nominal values and 3 errors"),
        ([RATES.replace("0.0002 0.001 0.001", "0.0002 0.001")], "other numbers of units, U or k"),
        ([RATES.replace("0.001 -0.002", "NaN -0.002")], "functions.rate.rows.0.deviation"),
        ([RATES.replace("0.001 -0.002", "x -0.002")], "'x' stands where a number should"),
        ([ANGLES.replace("1.5", "")], "'inner' has an error without an expanded uncertainty"),
        ([ANGLES.replace(r"\arcsecond", r"\metre")], r"an error is in \metre, not in one of"),
        ([RATES.replace(">2<", ">2 2 3<")], "more than one coverage factor"),
    ],
)
def test_what_does_not_state_a_table_is_refused_by_name(made, results, sentence):
    path = made(*results)
    with pytest.raises(Unusable) as refused:
        read_standard(path, "corrected")
    assert str(path) in str(refused.value)
    assert sentence in str(refused.value)


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "other.xml"
    path.write_text("<a/>", encoding="utf-8")
    with pytest.raises(Unusable, match="no digitalCalibrationCertificate"):
        read_standard(path, "corrected")
    path.write_text("no xml", encoding="utf-8")
    with pytest.raises(Unusable, match="is not XML"):
        read_standard(path, "corrected")
    with pytest.raises(Unusable, match="cannot be read"):
        read_standard(tmp_path / "absent.xml", "corrected")


@pytest.mark.skipif(not SCHEMAS.is_dir(), reason="the DCC schemas are not here")
def test_the_documents_of_these_tests_are_dccs(made):
    schema = etree.XMLSchema(etree.parse(SCHEMAS / "v3.3.0" / "dcc.xsd"))
    schema.assertValid(etree.parse(made(RATES, ANGLES)))
