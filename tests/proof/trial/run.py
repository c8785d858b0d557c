"""A sealed trial of `explain`, held from beginning to end."""

import json
import time
from collections.abc import Sequence
from typing import Annotated

import typer

from tasks.version import code_version
from tests.proof.peers import score as peers_page
from tests.proof.peers.score import MISSING, PeerScore, duties_of, peers_installed, score_peers
from tests.proof.real import run as real_page
from tests.proof.study import Out, Real, Seed, Short, folder_of
from tests.proof.trial.blind import ANSWERS, explain_blind
from tests.proof.trial.evidence import Trial, as_data, as_markdown, evidence_html
from tests.proof.trial.pictures import headline_svg
from tests.proof.trial.score import plain_of, score_all
from tests.proof.trial.seal import SEALED, draw, record_and_seal, sealed

MISSING_HTML = f'<p><span lang="en">{MISSING.en}</span><span lang="zh">{MISSING.zh}</span></p>'


def trial(
    seed: Seed = 1, short: Short = False, real: Real = None, out: Out = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="evidence.json on standard output.")
    ] = False,
) -> None:  # fmt: skip
    """The sealed trial: recordings of an independent plant, explained blind, held to the truth.

    The peers answer the same recordings where their libraries are installed. --real: besides, a
    folder of real recordings, by hand and with known changes hidden in them. Raises Unusable as
    `sealed`, and where a real recording is missing or broken.
    """
    folder, peers, started = folder_of(f"trial-{seed}", out), peers_installed(), time.perf_counter()
    declared = {"seed": seed, "short": short}
    seals = sealed(folder, declared, draw(seed, short), record_and_seal)
    results = real_page.held(real, folder_of("real", folder / "real"), seed) if real else None
    explain_blind(folder, peers)
    scores = score_all(folder)
    beside = score_peers(folder / SEALED, folder / ANSWERS) if peers else []
    held = Trial(seed, short, code_version(), seals, time.perf_counter() - started, scores)
    contents = _evidence(held, beside, peers, results)
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    print(contents["evidence.json" if as_json else "evidence.md"])


def _evidence(
    trial: Trial, beside: Sequence[PeerScore], peers: bool, results: real_page.Results | None
) -> dict[str, str]:
    """The files by name: the trial, what the peers answered, and the real recordings if any."""
    response = as_data(trial) | {"peers": [plain_of(each) for each in duties_of(beside)]}
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
