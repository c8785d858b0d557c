"""`make prove`: a sealed trial of `explain`, held from beginning to end."""

import json
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from flows.printing import print_rows, stdout
from flows.progress import counting
from schemas.base import Unusable
from tasks.version import code_version
from tests.proof import load
from tests.proof.faults.run_with_fault import DWELL_S, short_procedure
from tests.proof.kills import resume
from tests.proof.kills import run as kills
from tests.proof.peers import score as peers_page
from tests.proof.peers.score import MISSING, PeerScore, duties_of, peers_installed, score_peers
from tests.proof.real import run as real_page
from tests.proof.real.run import Results, run_all
from tests.proof.station import run as station
from tests.proof.stops import run as stops
from tests.proof.trial.evidence import (
    SUMMARY,
    Trial,
    as_data,
    as_markdown,
    besides,
    costs,
    evidence_html,
    figures,
    summary,
)
from tests.proof.trial.pictures import headline_svg
from tests.proof.trial.score import score_all
from tests.proof.trial.seal import ANSWERS, SEALED, draw, explain_blind, prepare, record_and_seal

T = TypeVar("T")
DEFAULT_OUT = "proof"
MISSING_HTML = f'<p><span lang="en">{MISSING.en}</span><span lang="zh">{MISSING.zh}</span></p>'


def run_prove(
    seed: int, short: bool, out: Path | None, as_json: bool, real: Path | None = None
) -> None:
    """Draws, seals, explains blind and scores; everything stays in the folder.

    real: a folder of real recordings, which are held first. The peers answer the same recordings
    where their libraries are installed. Raises Unusable for a folder that is in use or cannot be
    written, and where a real recording is missing or broken.
    """
    folder = out or Path(f"{DEFAULT_OUT}-{seed}")
    _make(folder)
    results = prove_real(real, folder / "real", seed) if real is not None else None
    peers = peers_installed()
    started = time.perf_counter()
    cases = draw(seed, short)
    with counting("record and seal") as report:
        seals = prepare(cases, folder, report, record_and_seal)
    with counting("explain blind") as report:
        explain_blind(folder, report, peers)
    scores = score_all(folder)
    beside = score_peers(folder / SEALED, folder / ANSWERS) if peers else []
    seconds = time.perf_counter() - started
    trial = Trial(seed, short, code_version(), seals, seconds, scores)
    contents = _evidence(trial, beside, peers, results)
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    if as_json:
        print(contents["evidence.json"], end="")
        return
    print_rows(f"The sealed trial, {len(scores)} recordings", SUMMARY, summary(trial))
    console = stdout(markup=False)
    for each in figures(scores):
        console.print(f"{each.what.en}: {each.reached} (asked: {each.asked}), {each.of}")
    for line in costs(scores):
        console.print(f"{line.what.en}: {line.before}; with explain {line.after}")
    for what, figure in besides(trial):
        console.print(f"{what}: {figure}")
    for name in (*contents, "seals.txt"):
        console.print(str(folder / name))


def run_station(count: int, out: Path | None) -> None:
    """Makes, explains and scores recordings of the virtual station.

    Raises Unusable for a folder that is in use or cannot be written.
    """
    folder = out or Path(f"{DEFAULT_OUT}-station")
    _make(folder)
    with counting("virtual station") as report:
        scores = station.run_all(folder, count, report)
    console = stdout(markup=False)
    for line in station.summary(scores):
        console.print(line)
    console.print(str(folder / "station.md"))


def run_loaded(count: int, out: Path | None) -> None:
    """Runs demonstrations with every core busy."""
    _held("load", out, partial(load.run_all, count=count), load.summary, lambda one: one.holds)


def run_kills(count: int, out: Path | None) -> None:
    """Kills acquisitions at random moments."""
    _held("kills", out, partial(kills.run_all, count=count), kills.summary,
          lambda one: not one.faults)  # fmt: skip


def run_stops(count: int, out: Path | None) -> None:
    """Stops stations at random moments."""
    _held("stops", out, partial(stops.run_all, count=count), stops.summary,
          lambda one: not one.faults and one.resumed is not False)  # fmt: skip


def run_resumes(count: int, out: Path | None) -> None:
    """Kills acquisitions and goes on with them."""
    procedure = short_procedure(DWELL_S, "x", resume.WARM_UP_S)
    run = partial(resume.run_all, count=count, procedure=procedure)
    _held("resumes", out, run, resume.summary, lambda one: one.holds)


def _held(
    name: str,
    out: Path | None,
    run_all: Callable[..., list[T]],
    summary: Callable[[list[T]], str],
    holds: Callable[[T], bool],
) -> None:
    """Holds a study, whose page is NAME.md in its folder, and prints the summary.

    Raises Unusable as for `run_station`, or where something does not hold.
    """
    folder = (out or Path(f"{DEFAULT_OUT}-{name}")).absolute()
    _make(folder)
    with counting(name) as report:
        found = run_all(folder, report=report)
    stdout(markup=False).print(str(folder / f"{name}.md"))
    if not all(map(holds, found)):
        raise Unusable(summary(found))
    stdout(markup=False).print(summary(found))


def prove_real(real: Path, folder: Path, seed: int) -> Results:
    """Hand analysis, known transformations hidden, explained blind and scored.

    Writes recordings, answers, real.json, real.md and real.html to the folder. Raises Unusable
    where one of the recordings is missing or broken.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with counting("real recordings") as report:
        results = run_all(real, folder, seed, code_version(), report)
    response = json.dumps(real_page.data(results), indent=1, ensure_ascii=False) + "\n"
    contents = {
        "real.json": response,
        "real.md": real_page.markdown(results),
        "real.html": real_page.real_html(results),
    }
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    return results


def _evidence(
    trial: Trial, beside: Sequence[PeerScore], peers: bool, results: Results | None
) -> dict[str, str]:
    """The files by name: the trial, what the peers answered, and the real recordings if any."""
    response = as_data(trial) | {"peers": [each.response() for each in duties_of(beside)]}
    more = [peers_page.section(beside) if peers else MISSING_HTML]
    declared = peers_page.markdown(beside) if peers else f"{MISSING.en}\n"
    if results is not None:
        response |= {"real": real_page.data(results)}
        more.append(real_page.section(results))
        declared += "\n" + real_page.markdown(results)
    return {
        "evidence.json": json.dumps(response, indent=1, ensure_ascii=False) + "\n",
        "evidence.md": as_markdown(trial) + "\n" + declared,
        "evidence.html": evidence_html(trial, more),
        "headline.svg": headline_svg(trial.scores),
    }


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        used = any(folder.iterdir())
    except OSError as error:
        raise Unusable(
            f"--out {folder} cannot be used ({error.strerror}); name a folder that can be written"
        ) from error
    if used:
        raise Unusable(f"--out {folder} is not empty; a trial needs a folder of its own")
