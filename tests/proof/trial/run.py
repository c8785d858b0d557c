"""A sealed trial of `explain`, held from beginning to end."""

import json
import time
from typing import Annotated

import typer

from tasks.version import code_version
from tests.proof.study import Out, Seed, Short, folder_of
from tests.proof.trial.blind import explain_blind
from tests.proof.trial.evidence import Trial, as_data, as_markdown, headline_svg
from tests.proof.trial.score import score_all
from tests.proof.trial.seal import draw, record_and_seal, sealed


def trial(
    seed: Seed = 1, short: Short = False, out: Out = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="evidence.json on standard output.")
    ] = False,
) -> None:  # fmt: skip
    """The sealed trial: recordings of an independent plant, explained blind, held to the truth.

    Raises Unusable as `sealed`.
    """
    folder, started = folder_of(f"trial-{seed}", out), time.perf_counter()
    declared = {"seed": seed, "short": short}
    seals = sealed(folder, declared, draw(seed, short), record_and_seal)
    explain_blind(folder)
    scores = score_all(folder)
    held = Trial(seed, short, code_version(), seals, time.perf_counter() - started, scores)
    contents = {
        "evidence.json": json.dumps(as_data(held), indent=1, ensure_ascii=False) + "\n",
        "evidence.md": as_markdown(held),
        "headline.svg": headline_svg(scores),
    }
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    print(contents["evidence.json" if as_json else "evidence.md"])
