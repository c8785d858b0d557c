"""The kept recordings: of the sealed trial, the rough trial and the station, and the real ones."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from tests.proof.ablation.judge import Answer, Verdict, by_names
from tests.proof.real.stated.judge import judged
from tests.proof.real.stated.known import KNOWN
from tests.proof.station import score as station
from tests.proof.station.case import cases
from tests.proof.trial.compare import compared
from tests.proof.trial.parameters import Truth
from tests.proof.trial.rough.score import scored_rough
from tests.proof.trial.seal import RECORDINGS, SEALED

STATION_CASES = 160
# What is known to be true of a recording by those who reported it or by hand: names of the
# catalogue; those in `tests.proof.real.stated.known` are not repeated.
TRUE_OF: dict[str, set[str]] = {
    "bmi160_board1": {"code_fault"},
    "openaxes_triangle250_radius": {"axis_mapping", "reference_frame", "time_offset"},
    "phone_basic_motions": {"time_offset", "lever_arm", "reference_frame"},
    "ring_trial1_seg5": {"time_offset", "lever_arm", "reference_frame"},
    "sunsided_turns": {"axis_mapping", "timestamp_jitter"},
    "tumvi_calib_imu1": {"reference_frame"},
    "arrival_stamps_16ms": {"time_offset"},
    "gravity_removed": {"gravity_removed", "lever_arm"},
    "gyro_range_1137": {"range_setting"},
    "gyro_z_inverted_labels_only": {"axis_mapping"},
    "large_misalignment": {"earth_rotation"},
    "logger_1hz": {"earth_rotation"},
    "logger_2hz": {"earth_rotation"},
    "low_byte_signed": {"code_fault"},
    "low_byte_signed_25hz": {"code_fault"},
    "low_byte_signed_no_table": {"code_fault"},
    "low_byte_signed_or": {"code_fault"},
    "one_bad_row": {"earth_rotation"},
    "ten_bad_rows": {"earth_rotation"},
}


@dataclass(frozen=True)
class Kept:
    """A recording in a folder, and how an answer about it is judged."""

    kind: str
    label: str
    folder: Path
    judge: Callable[[Answer], Verdict]


def kept(folder: Path, real: Path | None) -> list[Kept]:
    """All that are there, the kinds in turn, so that the first hundred hold all of them.

    folder: with plain/ and rough/, as a sealed trial leaves them, and station/recordings/.
    real: with real/, rough/ and field/.
    """
    kinds = [_plain(folder / "plain"), _rough(folder / "rough"), _station(folder / "station")]
    if real is not None:
        kinds.append(_real(real))
    turns = chain.from_iterable(zip_longest(*kinds))
    return [one for one in turns if one is not None]


def _labels(folder: Path) -> list[Path]:
    return sorted(folder.iterdir()) if folder.is_dir() else []


def _plain(folder: Path) -> Iterator[Kept]:
    for sealed in _labels(folder / SEALED):
        if (sealed / "trial.json").exists():
            yield Kept("sealed", sealed.name, folder / RECORDINGS / sealed.name,
                       lambda answer, sealed=sealed: _by_plain(sealed, answer))  # fmt: skip


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


def _rough(folder: Path) -> Iterator[Kept]:
    for sealed in _labels(folder / SEALED):
        if (sealed / "trial.json").exists():
            yield Kept("rough", sealed.name, folder / RECORDINGS / sealed.name,
                       lambda answer, sealed=sealed: _by_rough(sealed, answer))  # fmt: skip


def _by_rough(sealed: Path, answer: Answer) -> Verdict:
    declared, trial = _json(sealed / "truth.json"), _json(sealed / "trial.json")
    score = scored_rough(sealed.name, declared, trial, dict(answer), 0.0)
    wrong = [*score.wrong]
    right = [name for name in score.names if name != station.UNNAMED and name not in wrong]
    inside = sum(pair.inside for pair in score.parameters)
    return Verdict(tuple(right), tuple(wrong), inside, len(score.parameters))


def _station(folder: Path) -> Iterator[Kept]:
    asked = {f"{number:03d}": case for number, case in enumerate(cases(STATION_CASES), start=1)}
    for each in _labels(folder / RECORDINGS):
        if (each / "manifest.json").exists():
            yield Kept("station", each.name, each,
                       lambda answer, case=asked[each.name]: _by_station(case, answer))  # fmt: skip


def _by_station(case: Any, answer: Answer) -> Verdict:
    score = station.score(case, {**answer, "seconds": 0.0})
    named = [one["effect"] for one in answer["findings"] if one["effect"] != station.UNNAMED]
    right = [name for name in named if name not in score.wrong]
    told = [each for each in (score.low_pass, score.delay) if each != "absent"]
    return Verdict(
        tuple(right), score.wrong, sum(each in ("right", "group") for each in told), len(told)
    )


def _real(folder: Path) -> Iterator[Kept]:
    for kind in ("rough", "field", "real"):
        for each in _labels(folder / kind):
            if (each / "manifest.json").exists():
                yield Kept(f"real: {kind}", each.name, each,
                           lambda answer, name=each.name: _by_known(name, answer))  # fmt: skip


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
