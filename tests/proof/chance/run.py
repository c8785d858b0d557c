"""Explains null recordings of real ones, and clean ones of the sealed trial."""

import json
import time
from collections.abc import Iterator
from itertools import chain, product
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from schemas.base import Unusable
from schemas.recording import Recording
from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.explain.explanation import UNNAMED, Explanation
from tasks.version import code_version
from tasks.words import say
from tests.proof.chance.null import (
    Accepted,
    accepted,
    flipped,
    null_recording,
    offered,
    scrambled,
)
from tests.proof.chance.page import CLEAN, ORIGINAL, markdown
from tests.proof.plant.simulate import simulate
from tests.proof.trial.seal import DWELLS, draw

ANSWERS, PAGE = "chance.jsonl", "chance.md"
EVIDENCE = Path(__file__).parents[1] / "evidence" / PAGE
KINDS = {"flipped": flipped, "scrambled": scrambled}
DRAWS = 5  # of each kind, of each real recording
TRIALS = 4  # clean recordings: a bound of 1 % asks for 381 without a wrong name
MOST_RATE = 100  # Hz: of a clean recording, so that there are many
WAYS = ("real", "rough", "field")
Row = dict[str, Any]
Done = dict[tuple[str, str, int], Row]


def run_chance(
    folder: Path, seed: int, real: Path | None, minutes: float | None, write: bool
) -> None:
    """Explains what this code has not answered yet in the folder's chance.jsonl, and writes
    chance.md.

    real: with real/, rough/ and field/, explained with short ones first. minutes: after these no
    other recording is begun. write: the page into the evidence as well. Raises Unusable for a
    folder that cannot be written.
    """
    until = np.inf if minutes is None else time.monotonic() + 60.0 * minutes
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / ANSWERS).touch()
    except OSError as error:
        raise Unusable(
            f"--chance {folder} cannot be used ({error.strerror}); name a folder that can be "
            "written"
        ) from error
    done = {(row["kind"], row["label"], row["draw"]): row for row in _rows(folder)}
    spent = {_of_real(real, seed, done): 0.0, _clean(seed, done): 0.0}
    while spent and time.monotonic() < until:  # the one that has cost less so far
        source, started = min(spent, key=lambda one: spent[one]), time.process_time()
        if (row := next(source, None)) is None:
            del spent[source]
            continue
        spent[source] += time.process_time() - started
        with (folder / ANSWERS).open("a", encoding="utf-8") as stream:
            stream.write(json.dumps({**row, "code": code_version()}) + "\n")
    text = markdown(_rows(folder), code_version())
    for path in (folder / PAGE, *([EVIDENCE] if write else [])):
        path.write_text(text, encoding="utf-8")


def _rows(folder: Path) -> list[Row]:
    lines = (folder / ANSWERS).read_text(encoding="utf-8").splitlines()
    return [row for row in map(json.loads, lines) if row["code"] == code_version()]


def _of_real(real: Path | None, seed: int, done: Done) -> Iterator[Row]:
    """Of each recording the original, explained again where a run goes on, then nulls of it."""
    manifests = chain.from_iterable((real / way).glob("*/manifest.json") for way in WAYS if real)
    folders = sorted((one.parent for one in manifests), key=_bytes)
    models: dict[str, Accepted | None] = {}
    for number, folder in product(range(DRAWS), folders):
        name = folder.name
        asked = [kind for kind in KINDS if (kind, name, number) not in done]
        before = done.get((ORIGINAL, name, 0))
        if not asked or (before and "failed" in before):
            continue
        if name not in models:
            row: Row = {"kind": ORIGINAL, "label": name, "draw": 0}
            try:
                recording = read_folder(folder)
                explanation = explain(recording)
                models[name] = accepted(recording, explanation)
                row |= _reported(explanation, models[name])
            except Exception as failure:  # an answer, too
                models[name] = None
                row["failed"] = f"{type(failure).__name__}: {failure}"
            if not before:
                yield row
        if (model := models[name]) is None:
            continue
        for kind in asked:
            rng = np.random.default_rng([seed, crc32(f"{kind} {name}".encode()), number])
            null = null_recording(model, KINDS[kind], rng)
            yield _answered({"kind": kind, "label": name, "draw": number}, null, model)


def _bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.iterdir())


def _clean(seed: int, done: Done) -> Iterator[Row]:
    """Those of one trial after the other, as short as their procedures can be."""
    for number in range(seed, seed + TRIALS):
        for drawn in draw(number):
            if drawn.kind != "clean" or (CLEAN, drawn.label, number) in done:
                continue
            rate = min(drawn.case.rate_hz, MOST_RATE)
            case = drawn.case.model_copy(update={"rate_hz": rate, "dwell_s": min(DWELLS)})
            row = {"kind": CLEAN, "label": drawn.label, "draw": number}
            yield _answered(row, simulate(case).recording, None)


def _answered(row: Row, null: Recording, of: Accepted | None) -> Row:
    started = time.process_time()
    try:
        row |= _reported(explain(null), of)
    except Exception as failure:  # an answer, too
        row["failed"] = f"{type(failure).__name__}: {failure}"
    return row | {"seconds": round(time.process_time() - started, 1)}


def _reported(explanation: Explanation, of: Accepted | None) -> Row:
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
