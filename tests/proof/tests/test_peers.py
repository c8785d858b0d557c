"""Answers of explain and of the peers, held against one truth by the same rules."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from schemas.recording import ACCEL, GYRO
from tests.proof.peers.score import (
    METHODS,
    PEERS,
    PeerScore,
    holds_most,
    markdown,
    score_peers,
    section,
)
from tests.proof.plant.case import Case

CHANNELS = GYRO + ACCEL
ROWS, BLOCK_ROWS = 400, 4  # 100 Hz, blocks of 25 Hz
SIGMA = 0.1
NOTHING: dict[str, Any] = {
    "detected": False, "statistic": 1.0, "threshold": 2.0, "located": [], "names": [],
    "held_out_rms_ratio": 1.0, "held_out_gain": 0.0, "seconds": 0.5, "failed": None,
}  # fmt: skip

LEVER = {"lever_arm": {"r": [0.0, 0.0, 0.0]}}

Trial = Callable[..., list[PeerScore]]


def _found(channel: str, *names: str, gain: float = 20.0) -> dict[str, Any]:
    located = [{"channel": channel, "dimension": "rate", "description": "", "segments": [],
                "strength": 9.0}]  # fmt: skip
    declared = {"detected": True, "located": located, "names": list(names), "held_out_gain": gain}
    return NOTHING | declared


@pytest.fixture
def trial(tmp_path: Path) -> Trial:
    """Scores a trial of one case in which gyro_y is off by one from the standard's model.

    Keywords: a peer and its answer; explain names lever_arm in gyro_y and closes the gap.
    """

    def written(effects: dict[str, Any], kind: str = "single", **response: dict[str, Any]) -> Any:
        sealed, answers = tmp_path / "sealed/0001", tmp_path / "answers/0001"
        sealed.mkdir(parents=True)
        answers.mkdir(parents=True)
        case = Case(seed=1).model_dump(mode="json")
        declared = {"case": case, "effects": effects, "parameters": {"Kg": np.eye(3).tolist()}}
        _write(sealed / "truth.json", declared)
        declared = {"kind": kind, "asked_z": 10.0, "z": {}, "concealment": {}, "certificate": None,
                "floor": 0.0}  # fmt: skip
        _write(sealed / "trial.json", declared)
        off = np.where([channel == "gyro_y" for channel in CHANNELS], 1.0, 0.0)
        truth = {channel: np.full(ROWS, x) for channel, x in zip(CHANNELS, off, strict=True)}
        pq.write_table(pa.table({"t": np.arange(ROWS) / 100.0} | truth), sealed / "truth.parquet")
        finding = {"effect": "lever_arm", "indistinguishable_from": [], "parameters": [],
                   "held_out_gain": 9.0, "channels": ["gyro_y"]}  # fmt: skip
        answer = {"verdict": "explained", "findings": [finding], "seconds": 8.0}
        _write(answers / "answer.json", answer)
        declared_rows = {f"{channel}_nominal": np.zeros(ROWS) for channel in CHANNELS}
        declared_rows |= {f"{channel}_found": series for channel, series in truth.items()}
        pq.write_table(pa.table(declared_rows), answers / "prediction.parquet")
        peers = dict.fromkeys(PEERS, NOTHING) | response
        noise = dict.fromkeys(CHANNELS, SIGMA)
        _write(answers / "peers.json", {"noise": noise, "peers": peers})
        blocks = {f"{channel}_nominal": np.zeros(ROWS // BLOCK_ROWS) for channel in CHANNELS}
        blocks["gyro_y_sindy"] = np.full(ROWS // BLOCK_ROWS, 0.5)
        pq.write_table(pa.table(blocks), answers / "peers.parquet")
        return score_peers(tmp_path / "sealed", tmp_path / "answers")

    return written


def _write(path: Path, declared: dict[str, Any]) -> None:
    path.write_text(json.dumps(declared), encoding="utf-8")


def test_everybody_is_scored_on_the_same_blocks(trial: Trial) -> None:
    scores = trial(LEVER, sindy=_found("gyro_y", "lever_arm"))
    assert [one.method for one in scores] == list(METHODS)
    closed = {one.method: one.score.gap.closed for one in scores if one.score.gap}
    assert closed == pytest.approx({
        "mimucal": 1.0, "residual_threshold": 0.0, "stepwise_bic": 0.0, "sindy": 0.75,
        "gp_discrepancy": 0.0,
    })  # fmt: skip
    firsts = [one.score.gap.first for one in scores if one.score.gap]
    assert firsts == pytest.approx([ROWS / BLOCK_ROWS / SIGMA**2] * len(METHODS))


def test_one_ruler_for_all_though_fits_of_the_standard_differ(trial: Trial, tmp_path: Path) -> None:
    trial(LEVER, sindy=_found("gyro_y", "lever_arm"))
    path = tmp_path / "answers/0001/prediction.parquet"
    declared = pq.read_table(path)
    worse = {name: declared[name].to_numpy() - 3.0 * (name == "gyro_y_nominal") for name in
             declared.column_names}  # fmt: skip
    pq.write_table(pa.table(worse), path)
    scores = score_peers(tmp_path / "sealed", tmp_path / "answers")
    firsts = [one.score.gap.first for one in scores if one.score.gap]
    assert firsts == pytest.approx([ROWS / BLOCK_ROWS / SIGMA**2] * len(METHODS))


def test_names_and_places_follow_the_trials_rules(trial: Trial) -> None:
    response = {
        "residual_threshold": _found("gyro_y", "unnamed", gain=0.0),
        "stepwise_bic": _found("gyro_y", "lever_arm", "axis_tilt"),
        "sindy": _found("gyro_x", "unnamed", "lever_arm", gain=-3.0),
    }
    by = {one.method: one for one in trial(LEVER, **response)}
    assert by["residual_threshold"].located
    assert by["residual_threshold"].score.abstained
    assert not by["residual_threshold"].shown
    assert by["stepwise_bic"].score.right
    assert by["stepwise_bic"].score.wrong == ("axis_tilt",)
    assert by["stepwise_bic"].shown
    assert by["sindy"].score.right  # the first name that is one
    assert not by["sindy"].located
    assert not by["sindy"].shown
    assert not by["gp_discrepancy"].score.detected
    assert by["gp_discrepancy"].located is False


def test_finding_on_a_clean_case_is_no_abstention(trial: Trial) -> None:
    scores = trial({}, kind="clean", stepwise_bic=_found("gyro_y", "unnamed"))
    by = {one.method: one for one in scores}
    assert by["stepwise_bic"].abstained is False
    assert by["gp_discrepancy"].abstained is True
    assert by["gp_discrepancy"].located is None
    assert by["gp_discrepancy"].score.gap is None


def test_outside_the_catalogue_any_name_is_no_abstention(trial: Trial) -> None:
    response = {"stepwise_bic": _found("gyro_y", "lever_arm"), "sindy": _found("gyro_y", "unnamed")}
    by = {one.method: one for one in trial({"x_cable_drag": {}}, kind="outside", **response)}
    assert by["stepwise_bic"].abstained is False
    assert by["sindy"].abstained is True


def test_peer_that_failed_found_nothing(trial: Trial) -> None:
    failed = NOTHING | {"failed": "ValueError: no"}
    (sindy,) = (one for one in trial(LEVER, sindy=failed) if one.method == "sindy")
    assert sindy.score.failed == "ValueError: no"
    assert not sindy.score.detected


def test_recording_that_no_peer_answered_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "sealed/0001").mkdir(parents=True)
    assert score_peers(tmp_path / "sealed", tmp_path / "answers") == []
    assert section([]) == ""
    assert markdown([]) == ""


def test_channels_named_hold_the_largest_share() -> None:
    power = np.array([10.0, 80.0, 9.0, 0.0, 0.0, 1.0])
    assert holds_most(("gyro_y",), power)
    assert holds_most(("gyro_y", "gyro_z"), power)  # nearly as much as with gyro_x
    assert not holds_most(("gyro_x", "gyro_z"), power)
    assert not holds_most(("gyro_x",), power)
    assert not holds_most((), power)
