"""Holding a rough trial: drawn, sealed, explained blind by one engine or several, scored."""

import json
from pathlib import Path

from flows.printing import print_rows, stdout
from flows.progress import counting
from schemas.base import Unusable
from tests.proof.trial.rough.draw import draw_rough
from tests.proof.trial.rough.engine import OWN, explain_rough
from tests.proof.trial.rough.page import rough_html, rough_markdown
from tests.proof.trial.rough.score import score_rough
from tests.proof.trial.rough.seal import record_and_seal_rough
from tests.proof.trial.rough.table import COLUMNS, rows_rough
from tests.proof.trial.run import prepare
from tests.proof.trial.seal import SEALS, check_seals, digest_of

ANSWERS, DRAWN = "answers-", "drawn.json"


def run_rough(
    seed: int, short: bool, out: Path | None, engine: Path | None, minutes: float | None
) -> None:
    """Draws and seals, or takes up the same trial again; explains with one engine and scores all.

    Raises Unusable for a folder that is in use, cannot be written or holds another trial, and
    for an engine that is not there.
    """
    folder, engine = out or Path(f"proof-rough-{seed}"), (engine or OWN).absolute()
    if not engine.is_file():
        raise Unusable(f"--engine {engine} is not there; name a checkout's .venv/bin/mimucal")
    _sealed(folder, seed, short)
    answers = folder / f"{ANSWERS}{_name_of(engine)}"
    with counting("explain blind") as report:
        explain_rough(folder, answers, engine, report, minutes)
    by_engine = {
        each.name.removeprefix(ANSWERS): score_rough(folder, each)
        for each in sorted(folder.glob(f"{ANSWERS}*"))
    }
    kept = {name: scores for name, scores in by_engine.items() if scores}
    seals = digest_of(folder / SEALS)
    (folder / "rough.md").write_text(rough_markdown(seed, seals, kept), encoding="utf-8")
    (folder / "rough.html").write_text(rough_html(seed, seals, kept), encoding="utf-8")
    for name, scores in kept.items():
        rows = [tuple(row.cells()) for row in rows_rough(scores)]
        print_rows(f"Rough recordings, {name}: {len(scores)}", COLUMNS, rows)
    for name in ("rough.md", "rough.html"):
        stdout(markup=False).print(str(folder / name))


def _sealed(folder: Path, seed: int, short: bool) -> None:
    """The folder with this trial's recordings and seals, made if it is new."""
    declared = {"seed": seed, "short": short}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if (folder / SEALS).exists():
            if json.loads((folder / DRAWN).read_text(encoding="utf-8")) != declared:
                raise Unusable(f"--out {folder} holds another trial; name a folder of its own")
            check_seals(folder)
            return
        if any(folder.iterdir()):
            raise Unusable(f"--out {folder} is not empty; a trial needs a folder of its own")
    except OSError as error:
        raise Unusable(
            f"--out {folder} cannot be used ({error.strerror}); name a folder that can be written"
        ) from error
    with counting("record and seal") as report:
        prepare(draw_rough(seed, short), folder, report, record_and_seal_rough)
    (folder / DRAWN).write_text(json.dumps(declared), encoding="utf-8")


def _name_of(engine: Path) -> str:
    """The checkout's folder: <name>/.venv/bin/mimucal."""
    return engine.parents[2].name
