"""What every study shares: pieces of work, each answered once by a process begun anew, and a page.

A study draws its work from a seed and gives each piece a label. What is answered stays in the
study's folder; the same command goes on there, as long as the program is the same.
"""

import os
import pickle
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from flows.terminal import counting
from schemas.base import Unusable
from tasks.version import code_version

Work = TypeVar("Work")
Answer = TypeVar("Answer")
EVIDENCE = Path(__file__).parent / "evidence"
KEPT = "kept"

Count = Annotated[int, typer.Argument(metavar="N", min=1, help="How many.")]
Seed = Annotated[int, typer.Option(min=0, help="Of all that is drawn.")]
Out = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="Folder of the study, where it goes on; default: proof-NAME here."
    ),
]
Real = Annotated[Path | None, typer.Option(metavar="DIR", help="Folder of real recordings.")]
Minutes = Annotated[
    float | None, typer.Option(min=0, help="Begin nothing more after so many minutes.")
]
Short = Annotated[bool, typer.Option("--short", help="Some thirty recordings, not hundreds.")]
Write = Annotated[bool, typer.Option("--write", help="The page into the evidence, too.")]


def hold(
    name: str, work: Mapping[str, Work], answer: Callable[[Work], Answer],
    page: Callable[[list[Answer]], str], out: Path | None, *, write: bool = False,
    faults: Callable[[Answer], Iterable[str]] = lambda _: (), at_once: int | None = None,
    minutes: float | None = None,
) -> None:  # fmt: skip
    """A whole study: answers, its page, and exit 1 where an answer has faults."""
    folder = folder_of(name, out)
    found = list(answers(name, work, answer, folder, at_once=at_once, minutes=minutes).values())
    publish(name, page(found), folder, write, [each for one in found for each in faults(one)])


def folder_of(name: str, out: Path | None) -> Path:
    """The study's folder, made if it is new. Raises Unusable where it cannot be written."""
    folder = (out or Path(f"proof-{name}")).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unusable(
            f"--out {folder} cannot be used ({error.strerror}); name a folder that can be written"
        ) from error
    return folder


def answers(
    name: str, work: Mapping[str, Work], answer: Callable[[Work], Answer], folder: Path, *,
    at_once: int | None = None, minutes: float | None = None,
) -> dict[str, Answer]:  # fmt: skip
    """The answer to each piece of work by its label, in the order of the work.

    at_once: processes, as many as there are cores unless it is said; 0: in this one, one after the
    other. minutes: after these none is begun, and what has no answer is left out.
    """
    kept = folder / KEPT / name
    kept.mkdir(parents=True, exist_ok=True)
    files = {label: kept / f"{label}.pickle" for label in work}
    version = code_version()
    left = [label for label, file in files.items() if _kept(file, version) is None]
    end = None if minutes is None else time.time() + 60.0 * minutes
    one = partial(_answered, answer, end=end, version=version)
    with counting(name) as report:
        report(len(work) - len(left), len(work))
        if at_once == 0:
            for done, label in enumerate(left, start=len(work) - len(left) + 1):
                one(work[label], files[label])
                report(done, len(work))
        elif left:
            with fresh_processes(at_once) as pool:
                asked = [pool.submit(one, work[label], files[label]) for label in left]
                for done, each in enumerate(as_completed(asked), len(work) - len(left) + 1):
                    each.result()
                    report(done, len(work))
    found: dict[str, Answer] = {}
    for label, file in files.items():
        one_kept: tuple[Answer] | None = _kept(file, version)
        if one_kept:
            found[label] = one_kept[0]
    return found


def _answered(
    answer: Callable[[Work], Answer], work: Work, file: Path, end: float | None, version: str
) -> None:
    if end is None or time.time() < end:
        draft = file.with_suffix(".draft")
        draft.write_bytes(pickle.dumps((version, answer(work))))
        draft.replace(file)


def _kept(file: Path, version: str) -> tuple[Answer] | None:
    """The answer in a file, if this program gave it."""
    if not file.exists():
        return None
    by, answer = pickle.loads(file.read_bytes())
    return (answer,) if by == version else None


@contextmanager
def fresh_processes(at_once: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Processes begun anew, one thread each, or they hinder one another."""
    threads = os.environ.get("OPENBLAS_NUM_THREADS")
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    try:
        with ProcessPoolExecutor(at_once, mp_context=get_context("spawn")) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    finally:
        os.environ.pop("OPENBLAS_NUM_THREADS")
        if threads is not None:
            os.environ["OPENBLAS_NUM_THREADS"] = threads


def environment(**changes: str) -> dict[str, str]:
    """Of a process that is measured: no settings of others, one thread for linear algebra, and
    byte code kept as it is for a user.
    """
    others = ("PREFECT_", "MIMUCAL_", "PYTHONDONTWRITEBYTECODE")
    kept = {k: v for k, v in os.environ.items() if not k.startswith(others)}
    return kept | {"OPENBLAS_NUM_THREADS": "1", "AWS_EC2_METADATA_DISABLED": "true"} | changes


def publish(
    name: str, page: str, folder: Path, write: bool = False, faults: Sequence[str] = ()
) -> None:
    """Prints a page and keeps it in the folder; write: in the evidence, too. Exit 1 on faults."""
    for place in (folder, *([EVIDENCE] if write else [])):
        (place / f"{name}.md").write_text(page, encoding="utf-8")
    print(page)
    if faults:
        print("\n".join(faults), file=sys.stderr)
        raise typer.Exit(1)


def line(cells: Iterable[object]) -> str:
    """A row of a table in Markdown."""
    return f"| {' | '.join(' '.join(str(each).replace('|', '/').split()) for each in cells)} |"


def table(columns: Sequence[str], rows: Iterable[Iterable[object]]) -> list[str]:
    """The lines of a table."""
    return [line(columns), f"|{'---|' * len(columns)}", *map(line, rows)]


def share(what: str, asked: str, some: Sequence[Work], holds: Callable[[Work], bool]) -> str:
    """A row: what was asked, of how many, and of how many of them it holds."""
    count = sum(map(holds, some))
    held = f"{100.0 * count / len(some):.0f} % ({count} of {len(some)})" if some else "–"
    return line((what, asked, len(some), held))
