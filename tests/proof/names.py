"""Names that `explain` gives kept recordings of every kind, by what is known of each."""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, zip_longest
from pathlib import Path
from shutil import rmtree
from typing import Any

from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.version import code_version
from tests.proof import station
from tests.proof.plant.simulate import write
from tests.proof.real.stated import KNOWN, judged
from tests.proof.station import Case, cases, recording_of
from tests.proof.study import Minutes, Out, Real, Seed, Write, folder_of, hold, table
from tests.proof.trial.blind import UNNAMED, as_data
from tests.proof.trial.parameters import Truth, compared
from tests.proof.trial.rough import draw_rough, group_of, record_and_seal_rough, scored_rough
from tests.proof.trial.seal import DWELLS, RECORDINGS, SEALED, draw, record_and_seal

# What one answer says that is right and wrong, by what is known of the recording.

Answer = Mapping[str, Any]


@dataclass(frozen=True)
class Verdict:
    """right: names that are true or stand in a group with a true one. wrong: the others, as far as
    the recording is known well enough. inside, stated: intervals with a truth beside them.
    """

    right: tuple[str, ...]
    wrong: tuple[str, ...]
    inside: int = 0
    stated: int = 0


def by_names(answer: Answer, true: set[str], pairs: tuple[int, int] = (0, 0)) -> Verdict:
    """By the names of all that is true of a recording. pairs: intervals inside, and of how many."""
    named = [one for one in answer["findings"] if one["effect"] != UNNAMED]
    right = [one for one in named if group_of(one) & true]
    wrong = [one for one in named if one not in right]
    return Verdict(
        tuple(one["effect"] for one in right), tuple(one["effect"] for one in wrong), *pairs
    )


# The kept recordings: of the sealed trial, the rough trial and the station, and the real ones.

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
    right = (name for name in score.names if name not in (UNNAMED, *score.wrong))
    inside = sum(pair.inside for pair in score.parameters)
    return Verdict(tuple(right), score.wrong, inside, len(score.parameters))


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
    named = [one["effect"] for one in answer["findings"] if one["effect"] != UNNAMED]
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


COLUMNS = ("kind", "recordings", "not read", "right names", "wrong names", "intervals that hold")


@dataclass(frozen=True)
class Named:
    """What was named of a recording; verdict: None where `explain` fails, and says why."""

    kind: str
    label: str
    verdict: Verdict | None
    failed: str = ""


def names(
    real: Real = None, seed: Seed = 1, out: Out = None, minutes: Minutes = None,
    write: Write = False,
) -> None:  # fmt: skip
    """Names of short trials, of the station and of real recordings, right and wrong.

    --real: a folder with real/, rough/ and field/.
    """
    work = {
        re.sub(r"\W+", "-", f"{seed}-{one.kind}-{one.label}"): one
        for one in kept(folder_of("names", out), seed, real)
    }
    hold("names", work, _named, markdown, out, minutes=minutes, write=write)


def _named(one: Kept) -> Named:
    try:
        answer = as_data(explain(read_folder(one.recorded())))
    except Exception as failure:  # an answer, too
        return Named(one.kind, one.label, None, f"{type(failure).__name__}: {failure}")
    return Named(one.kind, one.label, one.judge(answer))


def markdown(rows: Sequence[Named]) -> str:
    """The counts of each kind, and every recording with a wrong name or none that could be read."""
    counts = []
    for kind in dict.fromkeys(one.kind for one in rows):
        some = [one for one in rows if one.kind == kind]
        answered = [one.verdict for one in some if one.verdict is not None]
        right, wrong, inside, stated = (
            sum(map(of, answered))
            for of in (
                lambda one: len(one.right), lambda one: len(one.wrong),
                lambda one: one.inside, lambda one: one.stated,
            )
        )  # fmt: skip
        counts.append((kind, len(some), len(some) - len(answered), right, wrong,
                       f"{inside} of {stated}"))  # fmt: skip
    wrong_ones = (
        (one.kind, one.label, ", ".join(one.verdict.wrong) if one.verdict else one.failed)
        for one in rows
        if one.verdict is None or one.verdict.wrong
    )
    return "\n".join([
        "# Names of kept recordings", "", f"mimucal {code_version()}.", "",
        *table(COLUMNS, counts), "", *table(("kind", "recording", "wrong"), wrong_ones), "",
    ])  # fmt: skip
