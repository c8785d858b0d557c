"""Runs the names of kept recordings without each rule; `page` makes the table of it."""

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, replace
from hashlib import blake2b
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from schemas.base import Unusable
from storage.formats.folder import read_folder
from tasks.explain import explain
from tasks.explain.events.event import Events
from tasks.explain.evidence import assemble
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import Explanation
from tasks.explain.inputs.prepared import Prepared, prepare
from tasks.explain.progress import silent
from tasks.explain.search.fitted import FittedSelection, Searched, searched
from tasks.model.model import Model
from tasks.motion.whole import Motion
from tests.proof.ablation.comparisons import COMPARISONS
from tests.proof.ablation.kept import Kept, kept
from tests.proof.ablation.page import markdown
from tests.proof.ablation.switch import Switch, Watch, off
from tests.proof.ablation.switches import EVIDENCE, TOGETHER

SWITCHES = (*EVIDENCE, *COMPARISONS)
ANSWERS, PAGE = "ablation.jsonl", "ablation.md"
PURPOSES = {one.name: one.purpose for one in SWITCHES} | {
    name: ", ".join(members) for name, members in TOGETHER.items()
}
SELECTION, EXPLANATION = "selection", "explanation"
LONGEST = 60.0  # s of processor time on one recording: after it no other rule is switched off
# What errors of the reference make is drawn anew only where a rule may change it.
DRAWN_ANEW = ("evidence.reference_errors", "evidence.scatter", "evidence.evidence")


def run_ablation(folder: Path, seed: int, real: Path | None, minutes: float | None) -> None:
    """Records and explains what has no answer in the folder's ablation.jsonl yet, and writes
    ablation.md.

    seed: of the trials. minutes: after these no other recording is begun. Raises Unusable for a
    folder that cannot be written.
    """
    recordings, answers = kept(folder, seed, real), folder / ANSWERS
    try:
        folder.mkdir(parents=True, exist_ok=True)
        answers.touch()
    except OSError as error:
        raise Unusable(
            f"--ablation {folder} cannot be used ({error.strerror}); name a folder that can be "
            "written"
        ) from error
    lines = answers.read_text(encoding="utf-8").splitlines()
    done = {(one["kind"], one["label"]) for one in map(json.loads, lines)}
    until = None if minutes is None else time.monotonic() + 60.0 * minutes
    for one in recordings:
        if (one.kind, one.label) in done:
            continue
        if until is not None and time.monotonic() > until:
            break
        with answers.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(_ablated(one), ensure_ascii=False) + "\n")
    rows = [json.loads(line) for line in answers.read_text(encoding="utf-8").splitlines()]
    (folder / PAGE).write_text(
        markdown(rows, {one.name: one.purpose for one in SWITCHES} | PURPOSES), encoding="utf-8"
    )


def _ablated(one: Kept) -> dict[str, Any]:
    """The answer with all rules, and of each that acts there the one without it, judged."""
    started = time.process_time()
    row: dict[str, Any] = {"kind": one.kind, "label": one.label}
    number = crc32(f"{one.kind} {one.label}".encode())
    switches = [each for each in SWITCHES if number % each.every == 0]
    row["asked"] = [*(each.name for each in switches), *TOGETHER]
    try:
        prepared = prepare(read_folder(one.recorded()), delay_sought=True)
        begun = time.process_time()
        found = searched(prepared)
    except Exception as failure:  # an answer, too
        return row | {"failed": f"{type(failure).__name__}: {failure}"}
    row["seconds"] = [begun - started, time.process_time() - begun]
    watch, drawn = Watch(switches), _Remembered()
    with watch.on(), drawn.on():
        watch.stage = SELECTION
        evidence = explain._selected(found, silent)
        watch.stage = EXPLANATION
        answer = response(assemble.explanation_of(prepared, evidence))
    row["answer"], row["judged"] = answer, asdict(one.judge(answer))
    row["seconds"].append(time.process_time() - begun - row["seconds"][1])
    row["without"] = {}
    for name, some in _to_try(switches, watch):
        if time.process_time() - started > LONGEST:
            row["asked"].remove(name)
            continue
        stages = set[str]().union(*(watch.acted[each.name] for each in some))
        with ExitStack() as without:
            if all(map(_remembers, some)):  # below what is switched off
                without.enter_context(drawn.on())
            for each in some:
                without.enter_context(off(each))
            other = _answered(prepared, found, evidence, stages)
        if isinstance(other, str):
            row["without"][name] = {"failed": other}
        elif other == answer:
            row["without"][name] = {}
        else:
            row["without"][name] = {"answer": other, "judged": asdict(one.judge(other))}
    return row | {"spent": time.process_time() - started}


def _to_try(switches: Sequence[Switch], watch: Watch) -> Iterator[tuple[str, list[Switch]]]:
    """Each switch that acts, and together those that make up for one another."""
    acting = {each.name: each for each in switches if each.name in watch.acted}
    yield from ((name, [each]) for name, each in acting.items())
    for name, members in TOGETHER.items():
        some = [acting[member] for member in members if member in acting]
        if len(some) > 1:
            yield name, some


def _answered(
    prepared: Prepared, found: Searched, evidence: Evidence, stages: set[str]
) -> dict[str, Any] | str:
    """The answer from the stage on in which the rule acts; a failure by what it says."""
    try:
        if SELECTION in stages:
            evidence = explain._selected(found, silent)
        else:  # what it keeps in mind was worked out by the rule
            evidence = replace(evidence, scatter=replace(evidence.scatter))
        return response(assemble.explanation_of(prepared, evidence))
    except Exception as failure:
        return f"{type(failure).__name__}: {failure}"


def response(explanation: Explanation) -> dict[str, Any]:
    """What an answer says, as far as rules may change it."""
    return {
        "verdict": explanation.verdict,
        "findings": [
            {
                "effect": one.effect,
                "group": list(one.group),
                "indistinguishable_from": list(one.indistinguishable),
                "refused": one.refusal and [one.refusal.kind, one.refusal.name],
                "channels": list(one.channels),
                "share": round(one.share, 3),
                "parameters": [each.model_dump() for each in one.parameters],
                "common": [each.model_dump() for each in one.common],
                "follows": None,
            }
            for one in explanation.findings
        ],
        "small": sorted(one.effect for one in explanation.small),
    }


def _remembers(switch: Switch) -> bool:
    return switch.attribute.partition(":")[0] not in DRAWN_ANEW


class _Remembered:
    """The two dearest steps of an explanation, worked out once for the same input."""

    def __init__(self) -> None:
        self._noise: dict[int, tuple[FittedSelection, set[int]]] = {}
        self._events: dict[bytes, Events] = {}

    @contextmanager
    def on(self) -> Iterator[None]:
        drawn, found = assemble.fitted_to_reference_noise, assemble.events_in_residual

        def by_fit(prepared: Prepared, standard: Model, evidence: Evidence) -> set[int]:
            if id(evidence.fit) not in self._noise:
                self._noise[id(evidence.fit)] = evidence.fit, drawn(prepared, standard, evidence)
            return self._noise[id(evidence.fit)][1]

        def by_residual(
            events: Events, residual: np.ndarray, noise: np.ndarray, motion: Motion,
            start: float = 0.0,
        ) -> Events:  # fmt: skip
            key = blake2b(residual.tobytes()).digest()
            if key not in self._events:
                self._events[key] = found(events, residual, noise, motion, start)
            return self._events[key]

        assemble.fitted_to_reference_noise = by_fit
        assemble.events_in_residual = by_residual
        try:
            yield
        finally:
            assemble.fitted_to_reference_noise, assemble.events_in_residual = drawn, found
