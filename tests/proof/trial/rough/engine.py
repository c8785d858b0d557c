"""Explains rough recordings with the command of an installed engine, each in its own process.

The process gets the folder of one recording and an empty home, and nothing of the trial.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tests.proof.trial.seal import RECORDINGS

OWN = Path(sys.executable).parent / "mimucal"  # beside the Python that runs the trial
ANSWER, COST, TROUBLE = "answer.json", "seconds.txt", "trouble.txt"
LIMIT = 900.0  # s that one recording may take

Report = Callable[[int, int], None]


def explain_rough(
    folder: Path, answers: Path, engine: Path, report: Report, minutes: float | None = None
) -> None:
    """Answers the recordings of a trial's folder in `answers`/<number>/.

    What has an answer there keeps it. minutes: after these none is begun any more; the rest stays
    without an answer.
    """
    end = None if minutes is None else time.monotonic() + 60.0 * minutes
    recordings = sorted((folder / RECORDINGS).iterdir())
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        asked = [
            pool.submit(_answered, each.resolve(), answers / each.name, engine, end)
            for each in recordings
        ]
        for done, each in enumerate(as_completed(asked), start=1):
            each.result()
            report(done, len(recordings))


def _answered(recording: Path, folder: Path, engine: Path, end: float | None) -> None:
    if (folder / COST).exists() or (end is not None and time.monotonic() > end):
        return
    folder.mkdir(parents=True, exist_ok=True)
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as home:
        surroundings = os.environ | {"MIMUCAL_HOME": home, "OPENBLAS_NUM_THREADS": "1"}
        surroundings.pop("PYTHONPATH", None)  # or another checkout's command would run this code
        try:
            done = subprocess.run(
                [engine, "explain", recording, "--json"],
                env=surroundings, cwd=home, capture_output=True, text=True, timeout=LIMIT,
            )  # fmt: skip
            response, trouble = done.stdout if done.returncode == 0 else "", done.stderr
        except subprocess.TimeoutExpired:
            response, trouble = "", f"no answer within {LIMIT:.0f} s"
    (folder / ANSWER).write_text(response, encoding="utf-8")
    (folder / TROUBLE).write_text(trouble, encoding="utf-8")
    (folder / COST).write_text(f"{time.perf_counter() - started:.1f}\n", encoding="utf-8")
