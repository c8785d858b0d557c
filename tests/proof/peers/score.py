"""What the peers' answers are worth, by the rules that `explain` itself is scored by.

Gaps are taken of means over the same blocks for everybody, in units of the white noise that the
readings show, and by one ruler: the misfit of the standard's model, fitted as explain does it or
as the peers do, whichever is nearer to the truth. Where an effect upsets one of those fits (lost
samples do, by a factor of hundreds) the two would not be comparable.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from schemas.recording import ACCEL, GYRO
from tests.proof.peers.blocks import block_means, block_numbers
from tests.proof.peers.peer import UNNAMED
from tests.proof.trial.score import Gap, Score, scored

CHANNELS = GYRO + ACCEL
MIMUCAL = "mimucal"
PEERS = ("residual_threshold", "stepwise_bic", "sindy", "gp_discrepancy")
METHODS = (MIMUCAL, *PEERS)
ENOUGH = 0.9  # of what as many channels can hold of the residual power


@dataclass(frozen=True)
class PeerScore:
    """One method on one recording. score: by the trial's rules.

    located: whether the channels named hold the largest share of what the standard's model leaves
    of the truth; None for clean cases. shown: whether segments that the fit did not see are
    predicted better by what was found. channels: those named.
    """

    method: str
    score: Score
    channels: tuple[str, ...]
    located: bool | None
    shown: bool

    @property
    def abstained(self) -> bool | None:
        """Whether nothing was named where no name is right; on a clean case nothing found.

        None where a name would be right.
        """
        if self.score.has_a_name:
            return None
        return not (self.score.detected if not self.score.effects else self.score.wrong)


@dataclass(frozen=True)
class Blocks:
    """Block means (n, 6) of the noise-free truth, and of each method: nominal and found."""

    truth: np.ndarray
    response: Mapping[str, tuple[np.ndarray, np.ndarray]]
    noise: np.ndarray

    @cached_property
    def known(self) -> np.ndarray:
        """(n, 6) bool: where the truth and every method's prediction are known."""
        every = [self.truth, *(one for pair in self.response.values() for one in pair)]
        return np.asarray(np.isfinite(every).all(axis=0))

    @cached_property
    def ruler(self) -> np.ndarray:
        """(6,) misfits of the standard's model in the fit of it that is nearest to the truth."""
        fits = [self.misfits(nominal) for nominal, _ in self.response.values()]
        return min(fits, key=lambda one: float(one.sum()))

    def misfits(self, prediction: np.ndarray) -> np.ndarray:
        """(6,) Σ|truth − prediction|²/σ² of each channel."""
        off = np.where(self.known, (self.truth - prediction) / self.noise, 0.0)
        return np.asarray((off**2).sum(axis=0))


def score_peers(sealed: Path, answers: Path) -> list[PeerScore]:
    """Every method on every recording that the peers answered."""
    return [
        one
        for folder in sorted(sealed.iterdir())
        if (answers / folder.name / "peers.json").exists()
        for one in _scores(folder, answers / folder.name)
    ]


def _scores(sealed: Path, answers: Path) -> Iterator[PeerScore]:
    declared, trial = _json(sealed / "truth.json"), _json(sealed / "trial.json")
    response = {MIMUCAL: _json(answers / "answer.json")}
    peers = _json(answers / "peers.json")
    response |= {name: _as_answer(peers["peers"][name]) for name in PEERS}
    channels = {MIMUCAL: _channels_of_mimucal(response[MIMUCAL])}
    for name in PEERS:
        channels[name] = tuple(dict.fromkeys(e["channel"] for e in peers["peers"][name]["located"]))
    blocks = None
    if declared["effects"] and "noise" in peers:
        blocks = blocks_of(sealed, answers, peers, "failed" not in response[MIMUCAL])
    for name in METHODS:
        gap, located = None, False if declared["effects"] else None
        if blocks is not None and name in blocks.response:
            found = float(blocks.misfits(blocks.response[name][1]).sum())
            gap = Gap(float(blocks.ruler.sum()), found, trial["floor"])
            located = holds_most(channels[name], blocks.ruler)
        score = scored(sealed.name, declared, trial, response[name], gap)
        gain = sum(one["held_out_gain"] for one in response[name].get("findings", []))
        yield PeerScore(name, score, channels[name], located, score.detected and gain > 0.0)


def _as_answer(response: Mapping[str, Any]) -> dict[str, Any]:
    """A peer's answer in the form of explain's, so that the same rules score it."""
    if response["failed"]:
        return {"failed": response["failed"], "seconds": response["seconds"]}
    findings = [
        {"effect": name, "indistinguishable_from": [], "parameters": [], "held_out_gain": 0.0}
        for name in (response["names"] if response["detected"] else [])
    ]
    if findings:
        findings[0]["held_out_gain"] = response["held_out_gain"]  # all that was found, together
    verdict = "no_mismatch" if not findings else "unexplained"
    if any(one["effect"] != UNNAMED for one in findings):
        verdict = "explained"
    return {"verdict": verdict, "findings": findings, "seconds": response["seconds"]}


def _channels_of_mimucal(answer: Mapping[str, Any]) -> tuple[str, ...]:
    every = (c for one in answer.get("findings", []) for c in one["channels"])
    return tuple(dict.fromkeys(every))


def holds_most(named: tuple[str, ...], power: np.ndarray) -> bool:
    """Whether the channels named hold as much of a power (6,), nearly, as any so many can."""
    own = float(sum(power[CHANNELS.index(channel)] for channel in named))
    best = float(np.sort(power)[::-1][: len(named)].sum())
    return bool(named) and own >= ENOUGH * best


def blocks_of(sealed: Path, answers: Path, peers: Mapping[str, Any], mimucal: bool) -> Blocks:
    """Truth and predictions of one recording over the same blocks."""
    kept = pq.read_table(answers / "peers.parquet")
    true = pq.read_table(sealed / "truth.parquet")
    numbers, count = block_numbers(true["t"].to_numpy()), len(kept)

    def means(table: Any, ending: str = "") -> np.ndarray:
        rows = [table[f"{channel}{ending}"].to_numpy().astype(float) for channel in CHANNELS]
        return block_means(np.column_stack(rows), numbers, count)

    response: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    if mimucal:
        declared = pq.read_table(answers / "prediction.parquet")
        response[MIMUCAL] = (means(declared, "_nominal"), means(declared, "_found"))
    nominal = np.column_stack([kept[f"{channel}_nominal"].to_numpy() for channel in CHANNELS])
    for name in PEERS:
        found = nominal.copy()
        for c, channel in enumerate(CHANNELS):
            if f"{channel}_{name}" in kept.column_names:
                found[:, c] = kept[f"{channel}_{name}"].to_numpy()
        response[name] = (nominal, found)
    noise = np.array([peers["noise"].get(channel, np.inf) for channel in CHANNELS])
    return Blocks(means(true), response, noise)


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
