"""Which standards a run was made with, and what they say they may be off by."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest

from schemas.calibration import AdoptedTerm
from schemas.certificate import Laboratory, Party
from schemas.laboratory import EquipmentLimit, MeasurementStandard
from schemas.recording import Manifest, Recording
from schemas.text import Remark
from storage.catalogue import equipment, results, runs
from storage.home import Home
from tasks.stages.estimate import estimate, in_use, standards_in_use, validity_of

PARTY = Party(name="L", name_zh="实", address="a", address_zh="址")


def table(certificate: str, rate: float, calibrated_on: date | None = None) -> MeasurementStandard:
    return MeasurementStandard.model_validate({
        "name": "Table", "name_zh": "台", "serial": "T-1", "accuracy": "",
        "certificate": certificate, "calibrated_on": calibrated_on,
        "limits": {"rate": {"half_width": rate, "distribution": "rectangular"}},
    })  # fmt: skip


def manifest(recording: Recording, *standards: object) -> Manifest:
    named = [s.model_dump(mode="json") if isinstance(s, MeasurementStandard) else s
             for s in standards]  # fmt: skip
    more = {"equipment": named, "recorded_at": "2026-05-02"}
    return recording.manifest.model_validate(recording.manifest.model_dump() | more)


def named(recording: Recording, *standards: object) -> Recording:
    return replace(recording, manifest=manifest(recording, *standards))


def test_the_register_goes_before_what_a_recording_names(home: Home, ideal_run: Callable) -> None:
    equipment.add([table("C-1", 3e-5, date(2025, 1, 1))], home, "Li")
    equipment.renew([table("C-2", 4e-5, date(2026, 6, 1))], home, "Li")
    named = manifest(ideal_run(), table("C-0", 1e-5))
    (then,) = standards_in_use(named, home, None, date(2026, 5, 2))
    assert then.certificate == "C-1"


def test_limits_come_from_the_certificate_of_the_day(home: Home, ideal_run: Callable) -> None:
    equipment.add([table("C-1", 3e-5, date(2025, 1, 1))], home, "Li")
    equipment.renew([table("C-2", 4e-5, date(2026, 6, 1))], home, "Li")
    limits = in_use(named(ideal_run(), table("C-0", 1e-5)), home, None).limits
    assert {name: (limit.half_width, limit.source) for name, limit in limits.items()} == {
        "rate": (3e-5, "C-1 (T-1)")
    }


def test_what_the_laboratory_states_itself_goes_before_its_standards(
    home: Home, ideal_run: Callable
) -> None:
    own = EquipmentLimit(half_width=7e-5, distribution="normal", source="S")
    laboratory = Laboratory(party=PARTY, equipment=(table("C-5", 2e-5),), limits={"rate": own})
    limits = in_use(named(ideal_run(), "no record"), home, laboratory).limits
    assert limits == {"rate": own}


def test_a_standard_of_the_recording_is_in_the_budgets(home: Home, ideal_run: Callable) -> None:
    recording = ideal_run(dwell=1.0)
    named = replace(recording, manifest=manifest(recording, table("C-1", 3e-5)))
    run, _ = runs.add(named, home)
    budget = estimate(run, home).items["gyro_scale_factor"].budgets["x"]
    (rate,) = [line for line in budget.inputs if line.symbol == "ε1"]
    assert (rate.half_width, rate.source) == (3e-5, "C-1 (T-1)")


def test_a_corrected_error_is_taken_off_before_a_run_is_estimated(
    home: Home, ideal_run: Callable
) -> None:
    """Gyros that read 300 °/s where the table turned 1e-4 less have a scale factor of 1.0001."""
    rows = [{"at": at, "deviation": 1e-4, "U": 1e-6} for at in (5.0, 300.0)]
    function = {"rate": {"deviation": "corrected", "rows": rows}}
    standard = MeasurementStandard.model_validate(
        table("C-1", 1e-5).model_dump() | {"limits": {}, "functions": function}
    )
    recording = ideal_run(dwell=1.0)
    named = replace(recording, manifest=manifest(recording, standard))
    run, _ = runs.add(named, home)
    made = estimate(run, home)
    assert made.items["gyro_scale_factor"].value["x"] == pytest.approx(1.0001, abs=1e-7)
    held = {segment.rate_deg_s for segment in made.segments if segment.kind == "rate"}
    assert {-300.0, 300.0} <= held  # labels stay what was set
    assert made.settings["limit of rate"] == "1e-06 (C-1 (T-1): deviation corrected)"
    own = EquipmentLimit(half_width=7e-5, distribution="normal", source="S")
    stated = estimate(run, home, None, Laboratory(party=PARTY, limits={"rate": own}))
    assert stated.items["gyro_scale_factor"].value["x"] == pytest.approx(1.0, abs=1e-7)


# What a run can be relied on for is judged by its readings as they were recorded.


def test_a_result_less_known_physics_does_not_judge_the_run(
    ideal_run: Callable[..., Recording], tmp_path: Path
) -> None:
    home = Home(tmp_path)
    run, _ = runs.add(ideal_run(dwell=1.0), home)
    made = estimate(run, home)
    plain = validity_of(run, home)
    term = AdoptedTerm(name="lever_arm", title="a lever arm", title_zh="杆臂", parameters=())
    doubt = Remark(code="doubt", en="not of the run", zh="与本次运行无关", run="invalid")
    remarks = (*made.remarks, doubt)
    less = made.model_copy(update={"terms": (term,), "remarks": remarks})
    assert less.validity != plain
    results.save(less, home)
    assert validity_of(run, home) == plain
