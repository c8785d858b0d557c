"""Null recordings: what an accepted model predicts, with its own residual torn out of its order.

A fast part and a slow one are treated apart, because a slow one that is turned round or moved in
stretches would jump at their ends as no sensor does. The slow part, a running median that keeps
steps, is cut where a channel crosses zero, each channel by itself.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product, zip_longest
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from scipy.ndimage import median_filter

from schemas.recording import ACCEL, GYRO, Recording
from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.explain.explanation import UNNAMED, Explanation, Finding
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.quality import wilson
from tasks.readings.lattice import quantiser_of
from tasks.version import code_version
from tasks.words import say
from tests.proof.plant.simulate import simulate
from tests.proof.study import Minutes, Out, Real, Seed, Write, hold, line, table
from tests.proof.trial.seal import DWELLS, Drawn, draw

CHANNELS = (*GYRO, *ACCEL)
TRIADS = (slice(0, 3), slice(3, 6))
STRETCH = 5.0, 30.0  # s, shortest and longest: longer than what a unit remembers of a motion
Tear = Callable[[list[np.ndarray], np.random.Generator], list[np.ndarray]]


@dataclass(frozen=True, eq=False)
class Accepted:
    """What was accepted of a recording.

    recording: its readings as explain has them. found: (n, 6), what its model predicts, NaN where
    that is not known. named: the first names it gave; names: with all that they cannot be told
    from. unreported: others in its model, as of what lost its name or belongs to a tracked body.
    """

    recording: Recording
    found: np.ndarray
    named: frozenset[str]
    names: frozenset[str]
    unreported: frozenset[str]


def accepted(recording: Recording, explanation: Explanation) -> Accepted:
    """recording: what was explained; its reference stays as it was, in its own axes."""
    every = (*explanation.findings, *explanation.small)
    names = frozenset[str]().union(*map(offered, every))
    model = explanation.determined
    terms = {key[0] for key in model.model.places} if model else set()
    terms |= {one.refusal.name for one in every if one.refusal}
    unreported = terms - names - {UNNAMED, *(term.name for term in STANDARD_TERMS)}
    own = replace(explanation.recording, reference=recording.reference)
    named = frozenset(one.effect for one in every) - {UNNAMED}
    return Accepted(own, explanation.found, named, names, frozenset(unreported))


def offered(finding: Finding) -> set[str]:
    """Every name that a finding offers for what it found; none of one without a name."""
    if finding.effect == UNNAMED:
        return set()
    return {finding.effect, *finding.group, *finding.indistinguishable}


def null_recording(of: Accepted, tear: Tear, rng: np.random.Generator) -> Recording:
    """The accepted model's readings with its residual torn, rounded to the codes of the recording.

    Others stay as they were recorded. Rows on codes beside rows off them would be no log at all.
    """
    imu = of.recording.imu
    readings = imu.stack(CHANNELS)
    known = np.isfinite(of.found) & np.isfinite(readings)
    interval = float(np.median(np.diff(imu.t)))
    null = readings.copy()
    for triad in TRIADS:
        rows = known[:, triad].all(axis=1)
        residual = (readings - of.found)[rows, triad]
        null[rows, triad] = of.found[rows, triad] + torn(residual, interval, tear, rng)
    for c, quantiser in enumerate(map(quantiser_of, readings.T)):
        if quantiser is not None:
            null[:, c] = quantiser.offset + quantiser.step * quantiser.codes(null[:, c])
    own = {c: null[:, k] for k, c in enumerate(CHANNELS) if c in imu.columns}
    return replace(of.recording, imu=replace(imu, columns={**imu.columns, **own}), digest="")


def torn(residual: np.ndarray, interval: float, tear: Tear, rng: np.random.Generator) -> np.ndarray:
    """(n, 3) of a triad: stretches of the fast part with all channels together, and of the slow.

    interval: s from row to row. What tear does to stretches keeps their power.
    """
    shortest, longest = (max(1, round(seconds / interval)) for seconds in STRETCH)
    if not len(residual):
        return residual
    slow = np.column_stack(
        [median_filter(each, shortest | 1, mode="nearest") for each in residual.T]
    )
    cuts = np.cumsum(rng.integers(shortest, longest + 1, 1 + len(residual) // shortest))
    fast = np.concatenate(tear(np.split(residual - slow, cuts[cuts < len(residual)]), rng))
    sewn = [_sewn(column, tear, rng) for column in slow.T]
    return np.asarray(fast + np.column_stack(sewn))


def _sewn(slow: np.ndarray, tear: Tear, rng: np.random.Generator) -> np.ndarray:
    """(n,) torn between its zero crossings. What is before the first and after the last ends at
    none: it stays in its place, with either sign.
    """
    first, *between = np.split(slow, 1 + np.flatnonzero(np.diff(np.sign(slow))))
    last = between.pop() if between else slow[:0]
    signs = rng.choice([-1.0, 1.0], 2)
    return np.concatenate([signs[0] * first, *tear(between, rng), signs[1] * last])


def flipped(parts: list[np.ndarray], rng: np.random.Generator) -> list[np.ndarray]:
    """Half of them with the other sign, at random: as many, so that few leave nothing as it was."""
    turned = rng.permutation(np.arange(len(parts)) % 2)
    return [-one if turn else one for one, turn in zip(parts, turned, strict=True)]


def scrambled(parts: list[np.ndarray], rng: np.random.Generator) -> list[np.ndarray]:
    """All of them in another order."""
    return [parts[k] for k in rng.permutation(len(parts))]


# The page: how many recordings have a wrong name, with the bound that this sets to its rate.

ORIGINAL, CLEAN = "original", "clean"
OF_KIND = {
    "flipped": "stretches of the residual with the other sign",
    "scrambled": "stretches of the residual in another order",
    CLEAN: "of the sealed trial, without effects, as they are",
}
COLUMNS = (
    "kind", "recordings", "of so many originals", "with a wrong name", "rate, at most (95 %)",
    "with an unreported name of the model", "names of the original found again",
    "with something unnamed", "not explained",
)  # fmt: skip
OF_REAL = ("recording", "found in the original", "null recordings", "wrong", "unreported")
METHOD = """\
A null recording is what the accepted model predicts of a real recording, with its own residual torn
out of its order: the fast part in stretches of 5 to 30 s, the channels of a triad together, the
slow part of each channel (a running median over 5 s) from one zero crossing to the next. Motion,
labels, temperatures and reference are those of the recording. Nothing is true in it but the
accepted model: a name is wrong where neither it nor one that it cannot be told from was found in
the original; small remainders count as well. What the accepted model has without reporting it under
a name (a withdrawn name; what every tracked body has) is in the null recording, and is counted
apart. A residual of few plateaus, as of a table with few rates, keeps them with other signs or in
another order, and an effect of its own may survive in them. Readings whose motion is unknown stay
as they were recorded; the others are rounded to the codes of the recording, which adds a twelfth of
a squared step to their variance. Null recordings of one original share its motion and the size of
its noise: the bound takes them as drawn independently."""
Row = dict[str, Any]


def markdown(rows: Sequence[Row], code: str) -> str:
    """The counts of each kind, what was named wrongly, and each real recording. code: its version.

    The bound is the upper one of the two-sided 95 % interval.
    """
    lines = ["# Wrong names by chance", "", f"mimucal {code}.", "", METHOD, ""]
    lines += table(COLUMNS, ())
    for kind, what in (*OF_KIND.items(), ("all", "together")):
        some = [row for row in rows if row["kind"] in (kind, *(OF_KIND if kind == "all" else ()))]
        lines.append(line((f"{kind}: {what}", *_cells(some))))
    lines += ["", "## Wrong names", ""]
    wrong = [row for row in rows if row["kind"] in OF_KIND and row.get("wrong")]
    if wrong:
        lines += table(("kind", "recording", "draw", "wrong", "true"), ())
    lines += [line((*_of(row), _names(row["wrong"]), _names(row["true"]))) for row in wrong] or [
        "None."
    ]
    lines += ["", "## Each real recording", ""]
    lines += table(OF_REAL, _originals(rows))
    return "\n".join(lines) + "\n"


def _cells(some: Sequence[Row]) -> Iterator[str]:
    answered = [row for row in some if "failed" not in row]
    wrong = sum(bool(row["wrong"]) for row in answered)
    yield str(len(answered))
    yield str(len({(row["label"], row["kind"] == CLEAN and row["draw"]) for row in answered}))
    yield str(wrong)
    yield f"{100.0 * upper_bound(wrong, len(answered)):.1f} %" if answered else "–"
    yield str(sum(bool(row["returned"]) for row in answered))
    again = [(name in row["names"]) for row in answered for name in row["found"]]
    yield f"{sum(again)} of {len(again)}"
    yield str(sum(bool(row["unnamed"]) for row in answered))
    yield str(len(some) - len(answered))


def upper_bound(wrong: int, of: int) -> float:
    """Of the rate, by Wilson's interval at 95 %."""
    return float(wilson(np.array([wrong]), np.array([of]))[1][0])


def _originals(rows: Sequence[Row]) -> Iterator[tuple[str, ...]]:
    for row in rows:
        if row["kind"] != ORIGINAL:
            continue
        nulls = [one for one in rows if one["label"] == row["label"] and "failed" not in one
                 and one["kind"] not in (ORIGINAL, CLEAN)]  # fmt: skip
        found = row.get("failed") or _names(row["names"])
        counts = (sum(bool(one[say]) for one in nulls) for say in ("wrong", "returned"))
        yield row["label"], found, str(len(nulls)), *map(str, counts)


def _of(row: Row) -> tuple[str, str, str]:
    return row["kind"], row["label"], str(row["draw"])


def _names(names: Sequence[str]) -> str:
    return ", ".join(names) or "–"


# Explains null recordings of real ones, and clean ones of the sealed trial.

KINDS = {"flipped": flipped, "scrambled": scrambled}
DRAWS = 5  # of each kind, of each real recording
TRIALS = 4  # clean recordings: a bound of 1 % asks for 381 without a wrong name
MOST_RATE = 100  # Hz: of a clean recording, so that there are many
WAYS = ("real", "rough", "field")


def chance(
    real: Real = None, seed: Seed = 1, out: Out = None, minutes: Minutes = None,
    write: Write = False,
) -> None:  # fmt: skip
    """Wrong names in null recordings of real ones, and in clean ones of the sealed trial.

    --real: a folder with real/, rough/ and field/, of which short recordings come first.
    """
    manifests = chain.from_iterable((real / way).glob("*/manifest.json") for way in WAYS if real)
    folders = sorted((one.parent for one in manifests), key=_bytes)
    nulls = [(f"{seed}-{folder.name}", (seed, folder)) for folder in folders]
    clean = [
        (f"{number}-clean-{drawn.label}", (number, drawn))
        for number in range(seed, seed + TRIALS)
        for drawn in draw(number)
        if drawn.kind == "clean"
    ]
    turns = chain.from_iterable(zip_longest(nulls, clean))
    hold("chance", dict(one for one in turns if one), _explained, _page, out, minutes=minutes,
         write=write)  # fmt: skip


def _page(found: Sequence[list[Row]]) -> str:
    return markdown([row for rows in found for row in rows], code_version())


def _explained(work: tuple[int, Path | Drawn]) -> list[Row]:
    """Of a real recording the original, then its nulls; a clean one as short as it can be."""
    seed, of = work
    if isinstance(of, Path):
        return list(_of_real(seed, of))
    rate = min(of.case.rate_hz, MOST_RATE)
    case = of.case.model_copy(update={"rate_hz": rate, "dwell_s": min(DWELLS)})
    row = {"kind": CLEAN, "label": of.label, "draw": seed}
    return [answered(row, simulate(case).recording, None)]


def _of_real(seed: int, folder: Path) -> Iterator[Row]:
    row: Row = {"kind": ORIGINAL, "label": folder.name, "draw": 0}
    try:
        recording = read_folder(folder)
        explanation = explain(recording)
        model = accepted(recording, explanation)
        yield row | reported(explanation, model)
    except Exception as failure:  # an answer, too
        yield row | {"failed": f"{type(failure).__name__}: {failure}"}
        return
    for number, kind in product(range(DRAWS), KINDS):
        rng = np.random.default_rng([seed, crc32(f"{kind} {folder.name}".encode()), number])
        null = null_recording(model, KINDS[kind], rng)
        yield answered({"kind": kind, "label": folder.name, "draw": number}, null, model)


def _bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.iterdir())


def answered(row: Row, null: Recording, of: Accepted | None) -> Row:
    started = time.process_time()
    try:
        row |= reported(explain(null), of)
    except Exception as failure:  # an answer, too
        row["failed"] = f"{type(failure).__name__}: {failure}"
    return row | {"seconds": round(time.process_time() - started, 1)}


def reported(explanation: Explanation, of: Accepted | None) -> Row:
    """What is said and what of it is wrong. of: what is true of a null recording."""
    every = (*explanation.findings, *explanation.small)
    true, unreported = (of.names, of.unreported) if of else (frozenset[str](), frozenset[str]())
    wrong, returned = list[str](), list[str]()
    for one in every:
        names = offered(one)
        if names and not names & true:
            (returned if names & unreported else wrong).append(one.effect)
    return {
        "names": [one.effect for one in every if one.effect != UNNAMED],
        "unnamed": [one.refusal.name if one.refusal else say(one.title, "en") for one in every
                    if one.effect == UNNAMED],
        "wrong": wrong,
        "returned": returned,
        "true": sorted(true),
        "found": sorted(of.named) if of else [],
    }  # fmt: skip
