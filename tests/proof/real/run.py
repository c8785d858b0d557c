"""Holding it: hand analysis first, then every recording explained blind in fresh processes."""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from schemas.recording import Recording
from storage.formats.folder import read_folder
from tests.proof.real.cases import Hidden, by_hand, hidden_cases, untouched
from tests.proof.real.fact import Answer, Claim, Fact, Judged, Recordings
from tests.proof.real.on_shaft import SHAFT
from tests.proof.real.pictures import Picture, pictures_of
from tests.proof.real.present import RECORDINGS, doubtful, facts_of
from tests.proof.real.score import Score, scored
from tests.proof.trial.blind import ANSWER
from tests.proof.trial.run import explain_blind
from tests.proof.trial.score import ANSWERS
from tests.proof.trial.seal import RECORDINGS as RECORDINGS_OUT

Report = Callable[[int, int], None]
Facts = tuple[tuple[Fact, tuple[Judged, ...]], ...]
Claims = tuple[tuple[Claim, bool | None], ...]


@dataclass(frozen=True)
class Results:
    """facts with what each of their recordings' answers says; claims with whether still made.

    None: explain failed there. explaining: s, all explanations together.
    """

    seed: int
    code_version: str
    facts: Facts
    claims: Claims
    scores: tuple[Score, ...]
    pictures: tuple[Picture, ...]
    seconds: float
    explaining: float


def run_all(folder: Path, out: Path, seed: int, code_version: str, report: Report) -> Results:
    """Everything, from the folder of the real recordings; writes recordings/ and answers/ to out.

    Raises Unusable where a recording is missing or not what it should be.
    """
    started = time.perf_counter()
    recordings = {name: _read(folder, name) for name in RECORDINGS}
    cases = hidden_cases(seed)
    asked: dict[str, Recording] = {name: recordings[name] for name in reversed(RECORDINGS)}
    asked["part"] = untouched(folder, SHAFT)
    asked |= {str(number): case.made(folder) for number, case in enumerate(cases)}
    answers = explained(asked, out, report)
    parts = judged(folder, recordings, cases, answers)
    spent = sum(float(each["seconds"]) for each in answers.values())
    return Results(seed, code_version, *parts, time.perf_counter() - started, spent)


def judged(
    folder: Path, recordings: Recordings, cases: Sequence[Hidden], answers: Mapping[str, Answer]
) -> tuple[Facts, Claims, tuple[Score, ...], tuple[Picture, ...]]:
    """Facts and claims beside the answers, scores of what was hidden, and the pictures."""
    facts = facts_of(recordings)
    scores = tuple(
        scored(case, answers[str(number)], _base(case, answers), by_hand(case, folder))
        for number, case in enumerate(cases)
    )
    return (
        tuple(
            (each, tuple(each.declared(answers[name]) for name in each.recordings))
            for each in facts
        ),
        tuple((each, _made(each, answers)) for each in doubtful(recordings)),
        scores,
        tuple(pictures_of(recordings, scores)),
    )


def explained(asked: Mapping[str, Recording], out: Path, report: Report) -> dict[str, Answer]:
    """The answer to each recording, by processes that get its folder and nothing else.

    Their folders are numbered in the order asked, so that the name tells nothing, either.
    """
    labels = {name: f"{number:03d}" for number, name in enumerate(asked, start=1)}
    for name, label in labels.items():
        write(asked[name], out / RECORDINGS_OUT / label)
    explain_blind(out, report)
    return {
        name: json.loads((out / ANSWERS / label / ANSWER).read_text(encoding="utf-8"))
        for name, label in labels.items()
    }


def write(recording: Recording, folder: Path) -> None:
    """A recording as a `mimu-recording/1` folder."""
    folder.mkdir(parents=True)
    streams = recording.streams()
    for name, stream in streams.items():
        pq.write_table(pa.table({"t": stream.t, **stream.columns}), folder / f"{name}.parquet")
    manifest = recording.manifest.model_copy(
        update={"streams": {name: f"{name}.parquet" for name in streams}}
    )
    (folder / "manifest.json").write_text(
        manifest.model_dump_json(indent=1, exclude_none=True), encoding="utf-8"
    )


def _made(claim: Claim, answers: Mapping[str, Answer]) -> bool | None:
    answer = answers[claim.recording]
    return None if "failed" in answer else claim.made(answer)


def _base(case: Hidden, answers: Mapping[str, Answer]) -> Answer:
    return answers["part" if case.recording == SHAFT else case.recording]


def _read(folder: Path, name: str) -> Recording:
    if not (folder / name).is_dir():
        raise Unusable(
            f"--real {folder}: there is no recording {name}; give the folder that holds "
            f"{', '.join(RECORDINGS)}"
        )
    return read_folder(folder / name)
