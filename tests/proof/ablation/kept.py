"""The kept recordings: of the sealed trial, the rough trial and the station, and the real ones."""

import json
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import chain, zip_longest
from pathlib import Path
from shutil import rmtree
from typing import Any

from tests.proof.ablation.judge import Answer, Verdict, by_names
from tests.proof.real.run import write
from tests.proof.real.stated import KNOWN, judged
from tests.proof.station import score as station
from tests.proof.station.case import Case, cases
from tests.proof.station.record import recording_of
from tests.proof.trial.parameters import Truth, compared
from tests.proof.trial.rough import draw_rough, record_and_seal_rough, scored_rough
from tests.proof.trial.seal import DWELLS, RECORDINGS, SEALED, draw, record_and_seal

MOST_OF = {"faint": 12, "several": 30, "clean": 20}  # recordings of a kind; of others one each
MOST_RATE = 100  # Hz
STATION_CASES = 60
# What is known to be true of a recording by those who reported it or by hand: names of the
# catalogue; those in `tests.proof.real.stated` are not repeated. All
# of `field` turn with Earth.
TRUE_OF: dict[str, set[str]] = {
    "bmi160_board1": {"code_fault"},
    "openaxes_triangle250_radius": {
        "axis_mapping",
        "reference_frame",
        "time_offset",
        "repeated_samples",
    },
    "phone_basic_motions": {"time_offset", "lever_arm", "reference_frame"},
    "ring_trial1_seg5": {"time_offset", "lever_arm", "reference_frame"},
    "sunsided_turns": {"axis_mapping", "timestamp_jitter"},
    "tumvi_calib_imu1": {"reference_frame"},
    "arrival_stamps_16ms": {"time_offset", "earth_rotation"},
    "gravity_removed": {"gravity_removed", "lever_arm", "earth_rotation"},
    "gyro_range_1137": {"range_setting", "earth_rotation"},
    "gyro_z_inverted_labels_only": {"axis_mapping", "earth_rotation"},
    "large_misalignment": {"earth_rotation"},
    "logger_1hz": {"earth_rotation"},
    "logger_2hz": {"earth_rotation"},
    "low_byte_signed": {"code_fault", "earth_rotation"},
    "low_byte_signed_25hz": {"code_fault", "earth_rotation"},
    "low_byte_signed_no_table": {"code_fault", "earth_rotation"},
    "low_byte_signed_or": {"code_fault", "earth_rotation"},
    "one_bad_row": {"earth_rotation"},
    "ten_bad_rows": {"earth_rotation"},
}


@dataclass(frozen=True)
class Kept:
    """A recording in a folder, how it is made there and how an answer about it is judged.

    last: the file that is written last; where it is, the recording is whole.
    """

    kind: str
    label: str
    folder: Path
    last: Path
    record: Callable[[], None] | None
    judge: Callable[[Answer], Verdict]

    def recorded(self) -> Path:
        """Its folder, recorded anew if it is not whole. Raises what a case raises that cannot be
        played.
        """
        if self.record is not None and not self.last.exists():
            for folder in {self.folder, self.last.parent}:
                rmtree(folder, ignore_errors=True)
            self.record()
        return self.folder


def kept(folder: Path, seed: int, real: Path | None) -> list[Kept]:
    """All of them, the kinds in turn, so that the first hundred hold all of them.

    folder: gets plain/ and rough/, as a sealed trial leaves them, and station/. seed: of the
    trials. real: with real/, rough/ and field/.
    """
    kinds = [
        _plain(folder / "plain", seed), _rough(folder / "rough", seed), _station(folder / "station")
    ]  # fmt: skip
    if real is not None:
        kinds.append(_real(real))
    turns = chain.from_iterable(zip_longest(*kinds))
    return [one for one in turns if one is not None]


def _plain(folder: Path, seed: int) -> Iterator[Kept]:
    """Of the sealed trial one of each effect and size, as short as its procedure can be."""
    chosen = Counter[tuple[str, tuple[str, ...], float | None]]()
    for drawn in draw(seed):
        effects = tuple(call.name for call in drawn.case.effects)
        key = drawn.kind, effects if drawn.kind in ("single", "outside") else (), drawn.z
        chosen[key] += 1
        if chosen[key] > MOST_OF.get(drawn.kind, 1):
            continue
        rate = min(drawn.case.rate_hz, MOST_RATE)
        case = drawn.case.model_copy(update={"rate_hz": rate, "dwell_s": min(DWELLS)})
        short = drawn.model_copy(update={"case": case})
        yield _of_trial("sealed", drawn.label, folder, partial(record_and_seal, short), _by_plain)


def _rough(folder: Path, seed: int) -> Iterator[Kept]:
    for drawn in draw_rough(seed):
        record = partial(record_and_seal_rough, drawn)
        yield _of_trial("rough", drawn.label, folder, record, _by_rough)


def _of_trial(
    kind: str,
    label: str,
    folder: Path,
    record: Callable[[Path], None],
    judge: Callable[[Path, Answer], Verdict],
) -> Kept:
    sealed = folder / SEALED / label
    return Kept(
        kind, label, folder / RECORDINGS / label, sealed / "trial.json",
        partial(record, folder), partial(judge, sealed),
    )  # fmt: skip


def _by_plain(sealed: Path, answer: Answer) -> Verdict:
    declared = _json(sealed / "truth.json")
    true = set(declared["effects"])
    truth = Truth(declared["effects"], declared["parameters"], declared["case"])
    pairs = [
        pair
        for one in answer["findings"]
        if one["effect"] in true and not one["effect"].startswith("x_")
        for pair in compared(truth, one["effect"], one["parameters"])[0]
    ]
    return by_names(answer, true, (sum(pair.inside for pair in pairs), len(pairs)))


def _by_rough(sealed: Path, answer: Answer) -> Verdict:
    declared, trial = _json(sealed / "truth.json"), _json(sealed / "trial.json")
    score = scored_rough(sealed.name, declared, trial, dict(answer), 0.0)
    wrong = [*score.wrong]
    right = [name for name in score.names if name != station.UNNAMED and name not in wrong]
    inside = sum(pair.inside for pair in score.parameters)
    return Verdict(tuple(right), tuple(wrong), inside, len(score.parameters))


def _station(folder: Path) -> Iterator[Kept]:
    for number, case in enumerate(cases(STATION_CASES), start=1):
        own = folder / f"{number:03d}"
        yield Kept(
            "station", own.name, own, own / "manifest.json", partial(_record, case, own),
            partial(_by_station, case),
        )  # fmt: skip


def _record(case: Case, folder: Path) -> None:
    write(recording_of(case), folder)


def _by_station(case: Case, answer: Answer) -> Verdict:
    score = station.score(case, {**answer, "seconds": 0.0})
    named = [one["effect"] for one in answer["findings"] if one["effect"] != station.UNNAMED]
    right = [name for name in named if name not in score.wrong]
    stated = [each for each in (score.low_pass, score.delay) if each != "absent"]
    return Verdict(
        tuple(right), score.wrong, sum(each in ("right", "group") for each in stated), len(stated)
    )


def _real(folder: Path) -> Iterator[Kept]:
    for kind in ("rough", "field", "real"):
        for manifest in sorted((folder / kind).glob("*/manifest.json")):
            own, judge = manifest.parent, partial(_by_known, manifest.parent.name)
            yield Kept(f"real: {kind}", own.name, own, manifest, None, judge)


def _by_known(name: str, answer: Answer) -> Verdict:
    if name in TRUE_OF:
        return by_names(answer, TRUE_OF[name])
    findings = [
        {**one, "follows": one["follows"] and {"en": one["follows"]}} for one in answer["findings"]
    ]
    claims = judged(name, {**answer, "findings": findings}, KNOWN, [])
    say = {word: tuple(one.response.split()[0].rstrip(":") for one in claims
                       if one.judgement == word) for word in ("right", "wrong")}  # fmt: skip
    return Verdict(say["right"], say["wrong"])


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
