"""Remarks told once with their segments, and who signs: whoever took the steps."""

from datetime import UTC, datetime

import pytest
from sample_certificate import calibration, certificate, content, laboratory, manifest

from schemas.certificate import Step, StepName
from schemas.recording import Segment
from schemas.text import Remark
from tasks.certificate.remarks import alike
from tasks.run_validity.remark import run_remark
from tasks.words import remark

NAMES = [f"rate_{axis}_{rate:+d}" for axis in "xyz" for rate in (-300, -100, -10, 10, 100, 300)]
MORNING = datetime(2026, 11, 21, 8, tzinfo=UTC)


def unsteady(name: str, number: int, **changes: object) -> Remark:
    varies = run_remark(
        "unsteady_rate", name, segment=name, witness="encoders", wander=f"{number / 100}",
        clause="7.2", percent="0.1",
    )  # fmt: skip
    return varies.model_copy(update=changes)


def test_what_is_so_of_one_segment_after_the_other_is_told_once_with_the_list() -> None:
    every = tuple(unsteady(name, number) for number, name in enumerate(NAMES))
    made = content(certificate(calibration(remarks=every)))
    (row,) = made.remarks
    zh, en = row.text
    assert en.startswith("rate_x_-300: according to ")
    assert en.endswith("to 17 more segments. This prevents a pass.")
    assert row.segments == ", ".join(NAMES[1:])
    assert "另有 17 段" in zh


def test_of_many_segments_only_number_and_kind_stand_in_the_remark() -> None:
    rests = [f"rest_{n}" for n in range(5)]
    labelled = [
        Segment(name=name, kind="static", t_start=n, t_end=n + 1) for n, name in enumerate(rests)
    ] + [
        Segment(name=n, kind="rate", axis=n[5], rate_deg_s=float(n[7:]), t_start=9, t_end=10)
        for n in NAMES
    ]
    of = manifest().model_copy(update={"segments": tuple(labelled)})
    slow = Remark(code="slow", en="Slow.", zh="采样慢。", segments=(*rests, *NAMES))
    few = Remark(code="few", en="Odd.", zh="异常。", segments=tuple(rests[:2]))
    made = content(certificate(calibration(remarks=(slow, few)), manifest=of))
    first, second = made.remarks
    assert first.text == (
        "采样慢。[静止 5 段；恒速转动 18 段]", "Slow. [5 rests; 18 constant rates]",
    )  # fmt: skip
    assert first.segments == ", ".join((*rests, *NAMES))
    assert (second.text[1], second.segments) == ("Odd. [rest_0, rest_1]", "")


def test_remarks_that_differ_in_more_than_figures_stay_apart() -> None:
    other = remark("unsteady_rate", "Something else.", NAMES[:1], blocks_pass=True, run="remarks")
    blocking = unsteady(NAMES[1], 1, blocks_pass=False)
    whole = Remark(code="unsteady_rate", en="A.", zh="A.")
    groups = alike([unsteady(NAMES[0], 1), other, blocking, whole, whole])
    assert [len(group) for group in groups] == [1, 1, 1, 1, 1]


def test_the_reasons_count_the_remarks_that_are_printed() -> None:
    blocking = tuple(unsteady(name, 1, blocks_pass=True) for name in NAMES)
    made = content(certificate(calibration(remarks=blocking)))
    assert made.reasons[-1][1] == "Remarks below that prevent a pass: 1."


def steps(**persons: str) -> tuple[Step, ...]:
    names: dict[str, StepName] = {"draft": "draft", "check": "check", "issue": "issue"}
    return tuple(
        Step(step=names[name], person=person, at=MORNING) for name, person in persons.items()
    )


@pytest.mark.parametrize(
    ("state", "taken", "names"),
    [
        ("draft", {"draft": "Sun"}, ["Wu", "not yet checked", "not yet issued"]),
        ("checked", {"draft": "Sun", "check": "Qian"}, ["Wu", "Qian", "not yet issued"]),
        ("issued", {"draft": "Sun", "check": "Qian", "issue": "Zhou"}, ["Wu", "Qian", "Zhou"]),
    ],
)
def test_who_took_a_step_signs_and_nobody_else(
    state: str, taken: dict[str, str], names: list[str]
) -> None:
    """Wu measured, and Sun drafted; the laboratory's file names Wang Fang and Zhang Wei."""
    made = content(certificate(state=state, steps=steps(**taken), operator="Wu"))
    signed = {each.role[1]: each for each in made.signatures}
    assert [signed[role].name[1] for role in ("Operator", "Checked by", "Issued by")] == names


def test_a_title_belongs_to_whom_the_laboratory_names() -> None:
    for person, title in (("Zhou", "not given"), ("张伟 Zhang Wei", "Technical director")):
        taken = steps(draft="Sun", check="Qian", issue=person)
        signed = content(certificate(steps=taken)).signatures
        assert signed[-1].title[1] == title
    anybody = certificate(laboratory=laboratory(issuer=None), steps=steps(issue="Zhou"))
    assert content(anybody).signatures[-1].title[1] == "Technical director"
