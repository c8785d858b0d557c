"""A customer's script, with numpy and the evidence file alone, finds the result and decides."""

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from schemas.base import Unusable
from schemas.calibration import AdoptedTerm, Calibration, EvidenceFile
from schemas.recording import Recording
from schemas.tolerance import Decision, Limit, Tolerance
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.calibrate.evidence_file import evidence_file
from tasks.conformity import decide
from tasks.specifications.register import specification_for
from tasks.validation.coverage import simulate

SCRIPT = Path(__file__).with_name("customers_script.py")
MOST_BYTES = 1_000_000
THREE_DIGITS = 5e-4
COLUMNS = ("value", "value_without_earth_rotation", "value_model")


def made(
    method: str, recording: Recording, decided: Decision | None = None
) -> tuple[Calibration, EvidenceFile]:
    specification = specification_for(recording.manifest.standard, method)
    result = calibrate(specification, recording, run="r", code_version="v")
    evaluation = evaluation_for(recording)
    return result, evidence_file(result, specification, recording, evaluation, decided)


def run(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    """The script, in an empty folder, by an interpreter that does not know this project."""
    command = [sys.executable, "-I", str(SCRIPT), *map(str, arguments)]
    return subprocess.run(command, cwd=folder, env={}, capture_output=True, text=True, check=False)


def table(
    folder: Path, evidence: EvidenceFile, *arguments: object
) -> dict[tuple[str, str], list[str]]:
    """What the script prints, by value."""
    file = folder / "evidence.json"
    file.write_text(evidence.model_dump_json(), encoding="utf-8")
    done = run(folder, file, *arguments)
    assert done.returncode == 0, done.stderr
    heading, *rows = (line.split() for line in done.stdout.splitlines())
    assert heading[3:7] == ["value", "u", "U", "k"]
    return {(row[0], row[1]): row[3:] for row in rows}


def stated(result: Calibration) -> Iterator[tuple[tuple[str, str], Any, Any, Any]]:
    """Every value of the result's JSON with its u and U."""
    for name, item in json.loads(result.model_dump_json())["items"].items():
        for column in COLUMNS:
            u = item.get(column.replace("value", "u", 1)) or item["u"]
            U = item.get(column.replace("value", "U", 1)) or item["U"]
            for element, value in (item[column] or {}).items():
                if value is not None:
                    yield (f"{name}.{element}", column), value, u[element], U[element]


def check_reproduced(folder: Path, result: Calibration, evidence: EvidenceFile) -> None:
    rows, expected = table(folder, evidence), list(stated(result))
    assert rows.keys() == {key for key, *_ in expected}
    assert expected
    for key, value, u, U in expected:
        found = list(map(float, rows[key][:3]))
        assert found[0] == pytest.approx(value, rel=1e-11, abs=1e-6 * u), key
        assert found[1:] == pytest.approx([u, U], rel=THREE_DIGITS), key


@pytest.mark.parametrize("method", ["jjf2003", "joint", "jjf1536"])
def test_every_value_and_its_uncertainty_of_a_simulated_run_follow_from_the_file_alone(
    method, tmp_path
):
    recording, _ = simulate(method, 11)
    result, evidence = made(method, recording)
    assert len(evidence.model_dump_json()) < MOST_BYTES
    assert all(each.combination for each in evidence.values)
    check_reproduced(tmp_path, result, evidence)


def test_points_that_scatter_and_fits_that_are_not_linear_are_told(real, tmp_path):
    recording = real("vn200_imu0_rate_table")
    holds = {"commanded_rate": {"half_width": 1e-5, "distribution": "rectangular"}}
    manifest = recording.manifest.model_copy(update={"table_time": holds})
    result, evidence = made("jjf2003", replace(recording, manifest=manifest))
    assert max(each.scatter for each in evidence.values) > 10.0
    check_reproduced(tmp_path, result, evidence)
    result, evidence = made("joint", real("xsens_multiposition"))
    assert not all(each.combination for each in evidence.values)
    assert all(each.lines for each in evidence.values if each.combination is None)
    check_reproduced(tmp_path, result, evidence)


@pytest.fixture(scope="module")
def earth(plant) -> tuple[Calibration, EvidenceFile]:
    return made("jjf2003", plant("plant_earth_rotation", 4))


def test_the_script_computes_what_it_prints(earth, tmp_path):
    """A mean that is moved moves each value by its weight, a larger prior its line alone."""
    result, evidence = earth
    check_reproduced(tmp_path, result, evidence)
    before, document = table(tmp_path, evidence), evidence.model_dump(mode="json")
    document["channels"][0]["means"][3] += 1.0
    (gravity,) = (each for each in document["sources"] if each["symbol"] == "g")
    gravity["u"] *= 100.0
    after = table(tmp_path, EvidenceFile.model_validate(document))
    moved = 0
    for each in evidence.values:
        assert each.combination is not None
        chosen = zip(each.combination.channel, each.combination.mean, each.combination.weight,
                     strict=True)  # fmt: skip
        weight = sum(w for channel, mean, w in chosen if (channel, mean) == (0, 3))
        key = (f"{each.item}.{each.element}", each.quantity)
        change = float(after[key][0]) - float(before[key][0])
        assert change == pytest.approx(weight, rel=1e-6, abs=1e-9)
        moved += weight != 0.0
    assert moved > 2
    scale = ("accel_scale_factor.x", "value")
    assert float(after[scale][1]) > 10.0 * float(before[scale][1])
    assert after["gyro_bias.z", "value"][1] == before["gyro_bias.z", "value"][1]


def tolerance(result: Calibration, rule: str) -> Tolerance:
    """Limits so many U below and above a value: wide, near on one side, too narrow, missed, one."""
    around = {
        "gyro_bias": (-40.0, 40.0), "gyro_fit_offset": (-0.8, 5.0), "accel_bias": (-0.5, 0.5),
        "gyro_scale_factor": (3.0, 9.0), "accel_cross_coupling": (-0.3, None),
    }  # fmt: skip
    limits = []
    for name, (below, above) in around.items():
        item = result.items[name]
        element, value = next(iter(item.value.items()))
        U = item.U[element]
        assert value is not None
        assert U is not None
        upper = None if above is None else value + above * U
        lower = value + below * U
        limits.append(
            Limit(item=name, unit=item.unit, elements=(element,), lower=lower, upper=upper)
        )
    return Tolerance(manufacturer="M", model="M", document="D", rule=rule, limits=tuple(limits))


@pytest.mark.parametrize("rule", ["simple_acceptance", "guard_band"])
def test_the_script_decides_as_the_laboratory_by_the_rule_of_the_file_and_by_another(
    rule, earth, tmp_path
):
    result, evidence = earth
    other = {"simple_acceptance": "guard_band", "guard_band": "simple_acceptance"}[rule]
    of_file, by_other = (decide(result, tolerance(result, each)) for each in (rule, other))
    decided = evidence.model_copy(update={"decision": of_file})
    verdicts = set()
    for expected, arguments in ((of_file, ()), (by_other, (other,))):
        rows = table(tmp_path, decided, *arguments)
        for limit in expected.limits:
            key = (f"{limit.item}.{limit.element}", limit.applied_to)
            assert rows[key][-1] == limit.verdict, key
            verdicts.add(limit.verdict)
    assert verdicts == {"pass", "fail", "inconclusive"}


def test_the_script_decides_by_a_customers_own_limits(earth, tmp_path):
    result, evidence = earth
    own = tmp_path / "limits.json"
    value, U = (result.items["gyro_bias"].model_dump()[each]["x"] for each in ("value", "U"))
    limits = {"gyro_bias": {"lower": value - 1.5 * U, "upper": value + 100 * U}}
    own.write_text(json.dumps(limits), encoding="utf-8")
    simple = table(tmp_path, evidence, "simple_acceptance", own)
    assert simple["gyro_bias.x", "value"][-1] == "pass"
    limits["gyro_bias"]["lower"] = value - 0.5 * U
    own.write_text(json.dumps(limits), encoding="utf-8")
    guarded = table(tmp_path, evidence, "guard_band", own)
    assert guarded["gyro_bias.x", "value"][-1] == "fail"
    assert guarded["gyro_scale_factor.x", "value"][-1] == "-"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [(b'{"format": "mimu-evi', "cannot be read as JSON"), (b"[1, 2]", "not 'mimu-evidence/1'"),
     (b'{"format": "mimu-calibration/1"}', "'mimu-calibration/1', not 'mimu-evidence/1'"),
     (b"\xff\xfe", "cannot be read as JSON")],
)  # fmt: skip
def test_the_script_says_in_a_sentence_what_is_no_evidence_file(content, sentence, tmp_path):
    (tmp_path / "damaged.json").write_bytes(content)
    done = run(tmp_path, "damaged.json")
    assert (done.returncode, done.stdout) == (1, "")
    assert sentence in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_result_of_another_day_or_way_has_no_evidence_file(earth, plant):
    result, _ = earth
    recording = plant("plant_earth_rotation", 4)
    specification, evaluation = specification_for("JJF 2003-2022", None), evaluation_for(recording)
    bias = result.items["gyro_bias"]
    moved = bias.model_copy(update={"value": bias.value | {"y": 0.3}})
    drawn = bias.model_copy(update={"uncertainty_kind": "Monte Carlo"})
    term = AdoptedTerm(name="thermal", title="t", title_zh="t")
    for changes, sentence in (
        ({"items": result.items | {"gyro_bias": moved}}, r"gyro_bias\.y of run r is 0\.3 in this"),
        ({"items": result.items | {"gyro_bias": drawn}}, "evaluated by Monte Carlo"),
        ({"terms": (term,)}, "was corrected for thermal first"),
    ):
        other = result.model_copy(update=changes)
        with pytest.raises(Unusable, match=sentence):
            evidence_file(other, specification, recording, evaluation)
