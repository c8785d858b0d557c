"""A new effect is one file: it is searched for, named and reported without any other change."""

from pathlib import Path

import numpy as np
import pytest

from schemas.recording import ACCEL, AXES, GYRO, Recording, Stream
from tasks.explain.correction.consequences import Consequences
from tasks.explain.explain import explain
from tasks.explain.locate.where import locate
from tasks.explain.report.discrepancy import discrepancy_of
from tasks.model import terms
from tasks.words import say
from tests.manifests import manifest_of

TOY = Path(__file__).parent / "toy"
TRUE = np.array([2e-3, -3e-3, 1e-3])
GRAVITY, RATE_HZ, DWELL = 9.8, 50.0, 6.0
NOISE = np.repeat([1e-4, 1e-3], 3)  # of a sample, rad/s and m/s²


@pytest.fixture
def recording() -> Recording:
    """Six orientations, in each of them eight rates and a rest."""
    rng, count = np.random.default_rng(17), round(DWELL * RATE_HZ)
    rows, segments = [], []
    for axis in range(3):
        for sign, mark in ((1.0, "+"), (-1.0, "-")):
            for rate in (20.0, -20.0, 60.0, -60.0, 150.0, -150.0, 300.0, -300.0, 0.0):
                turning = np.radians(rate) * np.eye(3)[axis]
                gyro = turning + TRUE * np.sqrt(np.abs(turning))
                reading = np.concatenate([gyro, sign * GRAVITY * np.eye(3)[axis]])
                start = DWELL * len(rows)
                rows.append(reading + NOISE * rng.standard_normal((count, 6)))
                segments.append({
                    "name": f"{mark}{AXES[axis]} {rate:+.0f}", "up": mark + AXES[axis],
                    "t_start": start, "t_end": start + DWELL,
                    **({"kind": "rate", "axis": AXES[axis], "rate_deg_s": rate} if rate
                       else {"kind": "static"}),
                })  # fmt: skip
    manifest = manifest_of(
        "toy", {"gravity_m_s2": GRAVITY}, standard="JJF 2003-2022", segments=segments
    )
    values = np.concatenate(rows)
    columns = dict(zip(GYRO + ACCEL, values.T.copy(), strict=True))
    return Recording(manifest, Stream(np.arange(len(values)) / RATE_HZ, columns), digest="0" * 64)


def test_a_toy_effect_of_one_file_is_found_named_and_reported(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(terms, "__path__", [*terms.__path__, str(TOY)])
    found = explain(recording)
    assert [finding.effect for finding in found.findings] == ["toy_effect"]
    assert found.verdict == "explained"
    (finding,) = found.findings
    for parameter, true in zip(finding.parameters, TRUE, strict=True):
        assert abs(parameter.value - true) < 4.0 * parameter.u
    assert say(finding.title, "en") == say(finding.title, "zh") == "toy effect"
    reported = discrepancy_of(found, locate(found), Consequences(((),), ((),)))
    assert reported.findings[0].statement.en.startswith("Toy effect: ")
    assert "toy effect" in reported.statement.en
    assert "toy effect" in reported.statement.zh
