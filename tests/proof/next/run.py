"""`make prove ARGS="--next 60 --seed 2"`: sealed cases that stay open, and what decides them."""

import itertools
import os
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from flows.progress import counting
from tests.proof.next.judge import Answer, played
from tests.proof.next.page import page
from tests.proof.report import publish

PAGE = "next.md"
AHEAD = 16  # cases that are played at a time, until so many as asked stay open


def run_next(count: int, seed: int, write: bool) -> None:
    """Draws cases until `count` of them stay open. What was played stays in proof-next-SEED, where
    the same command goes on.
    """
    folder = Path(f"proof-next-{seed}")
    folder.mkdir(exist_ok=True)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    answers: list[Answer] = []
    context = get_context("spawn")
    with ProcessPoolExecutor(os.cpu_count(), context) as pool, counting("open cases") as report:
        waiting, numbers = deque[Future[Answer]](), itertools.count()
        while len(_open(answers)) < count:
            for number in itertools.islice(numbers, AHEAD - len(waiting)):
                waiting.append(pool.submit(_kept, seed, folder, number))
            answers.append(waiting.popleft().result())
            report(len(_open(answers)), count)
        pool.shutdown(wait=True, cancel_futures=True)
    text = page(seed, answers)
    (folder / PAGE).write_text(text, encoding="utf-8")
    publish(PAGE, text, write, False)


def _open(answers: Sequence[Answer]) -> list[Answer]:
    return [one for one in answers if one.opened]


def _kept(seed: int, folder: Path, number: int) -> Answer:
    path = folder / f"{number:04d}.json"
    if not path.exists():
        draft = path.with_suffix(".draft")
        draft.write_text(played(seed, number).model_dump_json(indent=1), encoding="utf-8")
        draft.rename(path)
    return Answer.model_validate_json(path.read_text(encoding="utf-8"))
