"""What the certificate says about how it was measured and how far its verdict reaches."""

from datetime import date
from typing import Any

import pytest
from pydantic import ValidationError
from sample_certificate import (
    AXES,
    calibration,
    certificate,
    content,
    item,
    items,
    manifest,
    order,
    tolerance,
)

from schemas.calibration import AdoptedTerm, Calibration, SegmentUsed
from schemas.certificate import Replaced
from schemas.discrepancy import FoundParameter
from schemas.recording import Kind, Manifest, Mount, Segment
from schemas.text import Remark
from schemas.tolerance import Limit
from tasks.conformity import decide


def segment(name: str, kind: Kind, **more: Any) -> SegmentUsed:
    seconds = more.pop("seconds", 30.0)
    return SegmentUsed(
        name=name, kind=kind, t_start=0.0, t_end=seconds, origin="label", rows=100, **more
    )


def turned(**changes: Any) -> Calibration:
    """Two rests, x turned at four points, y at one."""
    used = (
        segment("up", "static", up="+x", seconds=30.02),
        segment("down", "static", up="-x", seconds=29.96),
        *(segment(f"x{r}", "rate", axis="x", up="+x", rate_deg_s=r) for r in (-300, -10, 10, 300)),
        segment("y", "rate", axis="y", up="+y", rate_deg_s=-50.0, seconds=31.0),
    )
    return calibration(segments=used, **changes)


def labelled(**changes: Any) -> Manifest:
    turn = Mount(quaternion_wxyz=(0.0, -1.0, 0.0, 0.0))
    labels = (
        Segment(name="up", kind="static", t_start=0, t_end=30, up="+x", turn_deg=0),
        Segment(name="down", kind="static", t_start=0, t_end=30, up="-x", turn_deg=180, mount=turn),
    )
    return manifest().model_copy(update={"segments": labels} | changes)


def test_the_conditions_tell_rates_dwell_positions_and_mounting() -> None:
    made = content(certificate(turned(), manifest=labelled())).conditions
    assert [(r.axis, r.points[1], r.count, r.largest) for r in made.rates] == [
        ("X", "±10, ±300", "4", "300"), ("Y", "−50", "1", "50"), ("Z", "—", "0", "—"),
    ]  # fmt: skip
    assert [field.value[1] for field in made.fields] == [
        "29.9 s at rest; 30.0 s at constant rate",
        "2 rests; 2 directions up: +x, −x; headings 0°, 180° (not each with every axis up)",
        "(1, 0, 0, 0); (0, −1, 0, 0)",
        "not given",
    ]


@pytest.mark.parametrize(
    ("rate_range", "answer"),
    [
        (None, "is not stated, so its inclusion could not be checked"),
        (300, "is 300 °/s; it was not included about Y, Z (up to 0 °/s)"),
        (10, "is 10 °/s; it was not included about Z (up to 0 °/s)"),
    ],
)
def test_a_largest_input_rate_that_was_not_included_is_a_deviation(
    rate_range: float | None, answer: str
) -> None:
    unit = manifest().unit.model_copy(update={"rate_range_deg_s": rate_range})
    made = content(certificate(turned(), manifest=labelled(unit=unit)))
    assert made.conditions.sentences == ()
    assert answer in made.remarks[0].text[1]
    assert made.remarks[0].text[1].startswith("Deviation: ")
    assert any("with deviations" in each[1] for each in made.statement)


def test_a_deviation_that_the_order_waives_is_printed_and_prevents_nothing() -> None:
    given = order().model_copy(update={"waived_conditions": ("largest_rate",)})
    made = content(certificate(turned(), order=given))
    assert (
        made.remarks[0].text[1].endswith("The client's order waives this condition (largest rate).")
    )
    assert any("with deviations" in each[1] for each in made.statement)


def test_a_largest_input_rate_that_was_included_about_every_axis_is_told() -> None:
    every = tuple(
        segment(axis, "rate", axis=axis, rate_deg_s=sign * 300.0)
        for axis in AXES for sign in (1, -1)
    )  # fmt: skip
    unit = manifest().unit.model_copy(update={"rate_range_deg_s": 300})
    made = content(certificate(calibration(segments=every), manifest=labelled(unit=unit)))
    assert "300 °/s; it was included about every axis" in made.conditions.sentences[0][1]
    assert not any("with deviations" in each[1] for each in made.statement)


def test_without_a_day_of_calibration_the_next_counts_from_the_certificate() -> None:
    made = {f.label[1]: f.value for f in content(certificate(calibrated_on=None)).front}
    assert made["Date of calibration"] == ("未提供", "not given")
    assert made["Recalibration due"] == (
        "2027-11-19（未提供校准日期，自证书日期起算）",
        "2027-11-19, counted from the date of issue because the date of calibration is not given",
    )


def test_an_order_received_after_the_calibration_is_refused() -> None:
    with pytest.raises(ValidationError, match=r"received = 2026-11-16, .* correct the order"):
        certificate(calibrated_on=date(2026, 11, 15))


def test_the_basis_names_only_what_was_determined_and_lists_the_rest() -> None:
    given = items()
    given["gyro_scale_factor"] = item("1", "7.2.1", AXES, [None] * 3, 1e-5)
    del given["gyro_fit_offset"]
    statement = content(certificate(calibration(items=given))).statement
    assert "7.2.1" not in statement[0][1]
    assert statement[0][0].startswith("本次校准依据 JJF 2003—2022")
    assert statement[1] == (
        "表 2 中未得出结果的项目：陀螺标度因数。",
        "Items of Table 2 not determined: Gyro scale factor.",
    )


def test_the_basis_says_what_was_taken_off_with_its_u() -> None:
    arm = FoundParameter(name="r_x", value=0.05, unit="m", u=1e-4)
    taken = AdoptedTerm(name="lever_arm", title="lever arm", title_zh="杆臂", parameters=(arm,))
    zh, en = content(certificate(calibration(terms=(taken,)))).statement[1]
    assert en.startswith(
        "Corrected in the readings beforehand: lever arm, r_x = (50.00 ± 0.20) mm (k = 2)"
    )
    assert "杆臂" in zh


def test_deviations_are_named_in_the_basis_and_on_the_cover() -> None:
    warm = Remark(code="c", en="Too warm.", zh="温度过高。", blocks_pass=True)
    made = content(certificate(calibration(remarks=(warm,))))
    assert made.statement[0][0].startswith("本次校准参照 JJF 2003—2022")
    assert "with deviations, see Remarks" in made.statement[0][1]
    specification = {f.label[1]: f.value for f in made.front}["Specification"]
    assert specification[0] == "参照 JJF 2003—2022，有偏离，见“说明”"


def test_a_verdict_on_some_elements_says_so() -> None:
    limit = Limit(item="gyro_bias", unit="deg/s", magnitude=1.0, elements=("x",))
    result = calibration()
    made = content(certificate(result, decide(result, tolerance(limits=(limit,)))))
    assert made.scope is not None
    in_part = "in 1 item only some elements have limits"
    assert made.scope[1] == f"1 of 8 items has limits and passes; {in_part}"


def test_a_fit_offset_with_a_limit_is_not_called_undecided() -> None:
    def answer(*limits: Limit) -> str:
        result = calibration()
        made = content(certificate(result, decide(result, tolerance(limits=limits))))
        return " ".join(en for _, en in made.sections[0].groups[2].sentences)

    bias = Limit(item="gyro_bias", unit="deg/s", magnitude=1.0)
    offset = Limit(item="gyro_fit_offset", unit="deg/s", magnitude=1.0)
    assert "no decision is based on it" in answer(bias)
    assert "no decision is based on it" not in answer(offset)
    assert "g_ii × 1 g and the component of Earth's rotation" in answer(offset)


def test_an_amendment_says_on_its_first_page_what_it_replaces_and_why() -> None:
    before = Replaced(number="MIMU-2026-0041", issued_on=date(2026, 11, 19), why="wrong address")
    front = content(certificate(replaces=before)).front
    (answer,) = [each.value for each in front if each.label[1] == "Replaces certificate"]
    assert answer[1] == "MIMU-2026-0041 of 2026-11-19; reason: wrong address"
    assert not [each for each in content(certificate()).front if each.label[0] == "代替证书"]
