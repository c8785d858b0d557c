"""What the peers' answers are worth, by the rules that `explain` itself is scored by.

Gaps are taken of means over the same blocks for everybody, in units of the white noise that the
readings show, and by one ruler: the misfit of the standard's model, fitted as explain does it or
as the peers do, whichever is nearer to the truth. Where an effect upsets one of those fits (lost
samples do, by a factor of hundreds) the two would not be comparable.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from schemas.recording import ACCEL, GYRO
from schemas.text import Statement as Text
from tasks.rendering import page
from tests.proof.peers.observation import UNNAMED, block_numbers, means_of_blocks
from tests.proof.study import bilingual, table
from tests.proof.trial.evidence import rate_words
from tests.proof.trial.score import Gap, Rate, Score, scored

# Whether the libraries are there that the peers need: they come with an extra of their own.

NEEDED = ("sklearn", "pysindy")
MISSING: Text = bilingual(
    "The peers were left out: pysindy or scikit-learn is missing; "
    "`.venv/bin/python -m pip install -e '.[peers]'` brings them.",
    "未与其他方法对比：缺少 pysindy 或 scikit-learn；可用 "
    "`.venv/bin/python -m pip install -e '.[peers]'` 安装。",
)


def peers_installed() -> bool:
    """False: `MISSING` says what to do."""
    return all(find_spec(name) is not None for name in NEEDED)


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
        return means_of_blocks(np.column_stack(rows), numbers, count)

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


# What `explain` and its peers do of the five duties, by kind of case.


@dataclass(frozen=True)
class Duties:
    """One method on the cases of one kind.

    locate: channels right. name: first name right, of those that have one; wrong: any name wrong.
    model: median share of the gap closed. show: unseen segments are predicted better. abstain:
    nothing named where nothing can be. seconds: median of one recording.
    """

    kind: str
    method: str
    cases: int
    detected: Rate
    locate: Rate
    name: Rate
    wrong: Rate
    model: float | None
    show: Rate
    abstain: Rate
    seconds: float


def kinds_of(scores: Iterable[PeerScore]) -> dict[str, list[PeerScore]]:
    """Clean cases, single effects by z, several, what is outside the catalogue; those there are."""
    kinds: dict[str, Callable[[PeerScore], bool]] = {
        "clean": lambda one: one.score.kind == "clean",
        **{
            f"one effect, z {z:g}": lambda one, z=z: (  # type: ignore[misc]
                one.score.kind in ("single", "faint") and one.score.asked_z == z
            )
            for z in (5.0, 10.0, 30.0, 100.0)
        },
        "several effects": lambda one: one.score.kind == "several",
        "outside the catalogue": lambda one: one.score.kind == "outside",
    }
    every = list(scores)
    listed = {name: [one for one in every if belongs(one)] for name, belongs in kinds.items()}
    return {name: group for name, group in listed.items() if group}


def duties_of(scores: Iterable[PeerScore]) -> list[Duties]:
    """A row for each kind of case and each method."""
    return [
        duties(kind, method, own)
        for kind, group in kinds_of(scores).items()
        for method in METHODS
        if (own := [one for one in group if one.method == method])
    ]


def duties(kind: str, method: str, scores: Sequence[PeerScore]) -> Duties:
    """The figures of some cases, at least one."""
    hidden = [one for one in scores if one.located is not None]
    nameable = [one for one in scores if one.score.has_a_name]
    nameless = [one for one in scores if one.abstained is not None]
    gaps = [one.score.gap.closed for one in scores if one.score.gap is not None]

    def rate(of: Sequence[PeerScore], holds: Callable[[PeerScore], object]) -> Rate:
        return Rate(sum(bool(holds(one)) for one in of), len(of))

    return Duties(
        kind, method, len(scores),
        detected=rate(scores, lambda one: one.score.detected),
        locate=rate(hidden, lambda one: one.located),
        name=rate(nameable, lambda one: one.score.right),
        wrong=rate(scores, lambda one: one.score.wrong),
        model=median(gaps) if gaps else None,
        show=rate(hidden, lambda one: one.shown),
        abstain=rate(nameless, lambda one: one.abstained),
        seconds=median(one.score.seconds for one in scores),
    )  # fmt: skip


# The section of evidence.html and evidence.md that holds the peers beside `explain`.

TEMPLATE = Path(__file__).parent / "templates" / "section.html"
TITLE: Text = bilingual("What an engineer would use today", "与现有方法的对比")
METHOD: Text = bilingual(
    "The same recordings, inputs and held-out segments, answered by four peers: means of the "
    "residuals against a threshold; forward stepwise regression with BIC over a generic library; "
    "sparse regression (SINDy, pysindy); a Gaussian process for the discrepancy (Kennedy & "
    "O'Hagan). Their thresholds were set on clean recordings of other seeds, to about 1 % false "
    "alarms. Rows are whitened by the Allan variance for all that regress.",
    "四种现有方法使用相同的记录、输入和留出段：残差均值阈值；通用函数库上的BIC前向逐步回归；稀疏回归（SINDy，pysindy）；"
    "高斯过程失配项（Kennedy与O'Hagan）。其阈值以其他种子的无失配记录整定，虚警率约1 %。"
    "各回归方法均先按Allan方差白化。",
)
RULES: Text = bilingual(
    "Located: the channels named hold the largest share of what the standard's model leaves of "
    "the truth. Named: the first name is right, of the cases that have a name. Modelled: share of "
    "the gap closed, of means over the same 25 Hz blocks and against the same fit of the "
    "standard's model for everybody, the median. Shown: "
    "segments that the fit did not see are predicted better. Abstained: nothing found on a clean "
    "recording, no name given outside the catalogue. Two of the peers name nothing by their "
    "nature, and one of them models nothing.",
    "定位：所指通道占规范模型残余真值功率的最大份额。命名：在有正确名称的情形中首个名称正确。建模：缺口闭合份额，"
    "各方法均取相同25 Hz分块均值与同一规范模型拟合，取中位数。展示：对拟合未见的段预测更好。"
    "不作判断：无失配记录无发现，目录外因素不予命名。其中两种方法本身不命名，其一不建模。",
)
COLUMNS = (
    "case", "method", "cases", "detected", "located", "named", "any wrong", "gap closed",
    "shown", "abstained", "seconds",
)  # fmt: skip
METHOD_WORDS = {
    "mimucal": "mimucal explain",
    "residual_threshold": "residual threshold",
    "stepwise_bic": "stepwise BIC",
    "sindy": "SINDy",
    "gp_discrepancy": "Gaussian process",
}


def section(scores: Sequence[PeerScore]) -> str:
    """HTML in both languages; empty where no peer answered."""
    if not scores:
        return ""
    rows = [cells(duties) for duties in duties_of(scores)]
    return page(TEMPLATE, title=TITLE, method=METHOD, rules=RULES, columns=COLUMNS, rows=rows,
                numeric=range(2, len(COLUMNS)))  # fmt: skip


def markdown(scores: Sequence[PeerScore]) -> str:
    """The same table; empty where no peer answered."""
    if not scores:
        return ""
    rows = table(COLUMNS, map(cells, duties_of(scores)))
    return "\n".join([f"## {TITLE.en}", "", METHOD.en, "", *rows, "", RULES.en, ""])


def cells(duties: Duties) -> list[str]:
    """A row as words, in the order of COLUMNS."""
    rates = (duties.detected, duties.locate, duties.name, duties.wrong)
    gap = "–" if duties.model is None else f"{round(duties.model, 2) + 0.0:.2f}".replace("-", "−")
    return [
        duties.kind,
        METHOD_WORDS[duties.method],
        f"{duties.cases}",
        *(rate_words(rate, False) for rate in rates),
        gap,
        rate_words(duties.show, False),
        rate_words(duties.abstain, False),
        f"{duties.seconds:.1f}",
    ]
