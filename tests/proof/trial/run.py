"""Holding a trial: every case is recorded and sealed, then every recording is explained blind."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from storage.formats.folder import read_folder
from tests.proof.trial.blind import answer
from tests.proof.trial.score import ANSWERS
from tests.proof.trial.seal import RECORDINGS, set_seals

Report = Callable[[int, int], None]
Case = TypeVar("Case")


def prepare(
    cases: Sequence[Case], folder: Path, report: Report, record: Callable[[Case, Path], None]
) -> str:
    """Records and seals every case; returns the SHA-256 of seals.txt.

    record: plays one case, its recording and its truth to the folder. Raises what a case raises
    that cannot be played.
    """
    with _fresh_processes() as pool:
        made = [pool.submit(record, drawn, folder) for drawn in cases]
        for done, each in enumerate(as_completed(made), start=1):
            each.result()
            report(done, len(cases))
    return set_seals(folder)


def explain_blind(folder: Path, report: Report, peers: bool = False) -> None:
    """Answers every recording of a folder, in processes that know nothing else of it.

    peers: whether the peers answer it, too; they need libraries of their own.
    """
    recordings = sorted((folder / RECORDINGS).iterdir())
    with _fresh_processes() as pool:
        asked = [
            pool.submit(_answered, each, folder / ANSWERS / each.name, peers) for each in recordings
        ]
        for done, each in enumerate(as_completed(asked), start=1):
            each.result()
            report(done, len(recordings))


def _answered(recording: Path, folder: Path, peers: bool) -> None:
    read = read_folder(recording)
    answer(read, folder)
    if peers:
        from tests.proof.peers.answer import answer_peers  # late: an extra that may be missing

        answer_peers(read, folder)


@contextmanager
def _fresh_processes() -> Iterator[ProcessPoolExecutor]:
    """A process for each core, begun anew; one thread each, or they hinder one another."""
    threads = os.environ.get("OPENBLAS_NUM_THREADS")
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    try:
        with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    finally:
        os.environ.pop("OPENBLAS_NUM_THREADS")
        if threads is not None:
            os.environ["OPENBLAS_NUM_THREADS"] = threads
