"""What is known of the real recordings by their makers and by hand, beside what explain says."""

import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from storage.formats.folder import read_folder
from tasks.version import code_version
from tests.proof.real.facts import RECORDINGS, Answer, Claim, Fact, doubtful, facts_of, in_words
from tests.proof.study import Minutes, Out, Write, answers, folder_of, publish, table

RIG = "maker's register map, and the phase of the gyro against the encoder, by hand"
POSES = "least squares of the readings on the poses and their derivatives, 10 to 12 Hz, by hand"
DELAYS = ("time_offset", "bandwidth")
DELAY_PARAMETERS = ("seconds", "time_constant")
CODES = "the values that occur, counted by hand"
EVERYTHING = ("*",)


@dataclass(frozen=True)
class Known:
    """One fact of a recording.

    names: of the catalogue that state it; EVERYTHING: any that no other fact is about. there:
    whether it is; None: what is known does not decide it. within: from and to, SI, of parameters
    that state its size; several of one name of DELAYS count together.
    """

    recording: str
    names: tuple[str, ...]
    there: bool | None
    fact: str
    source: str
    within: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def _delay(recording: str, low: float, high: float, fact: str, source: str = RIG) -> Known:
    within = dict.fromkeys(DELAY_PARAMETERS, (low, high))
    return Known(recording, DELAYS, True, fact, source, within)


def _codes(recording: str) -> Known:
    fact = "accelerometer codes are 0.01 g apart, coarser than the noise at rest"
    return Known(recording, ("coarse_quantisation",), True, fact, CODES)


KNOWN: tuple[Known, ...] = (
    _delay(
        "encoder_mpu6050_pitch_slow", 4.8e-3, 14e-3,
        "the unit's low-pass alone is 4.8 ms late; the same rig about other axes 10 to 12 ms",
    ),
    _codes("encoder_mpu6050_pitch_slow"),
    _delay("encoder_roll_slow", 10e-3, 12e-3, "the gyro lags the encoder by 10 to 12 ms"),
    _codes("encoder_roll_slow"),
    _delay("encoder_yaw_fast", 11e-3, 13e-3, "the gyro lags the encoder by about 12 ms"),
    _codes("encoder_yaw_fast"),
    Known(
        "encoder_yaw_fast", ("axis_wobble", "axis_tilt"), False,
        "the accelerometers show no tilt that follows the angle", "their means by angle, by hand",
    ),
    Known(
        "encoder_yaw_fast", ("structural_compliance",), None,
        "the shaft between encoder and unit twists, at 10.5 Hz; a lean by rate² was not looked for",
        "swing of the unit against that of the encoder, by hand",
    ),
    Known(
        "tumvi_room4", ("reference_frame",), True,
        "tracked body and unit are turned by 0.13° against each other", POSES,
    ),
    Known(
        "tumvi_room4", EVERYTHING, False,
        "calibrated by its authors, poses in the unit's own frame and on its clock (0.08 ms); "
        "lever arm (−0.1, −1.3, 0.1) ± 1.3 mm: nothing is left out",
        "the authors' documentation, and " + POSES,
    ),
    _delay("broad_18", 4.1e-3, 4.2e-3, "the gyro lags the poses by 4.1 to 4.2 ms", POSES),
    Known(
        "broad_18", ("lever_arm",), True,
        "accelerometers at (2.8, −1.5, 7.3) mm from the tracked origin, known to some 2 mm", POSES,
        {"r_x": (1e-3, 5e-3), "r_y": (-4e-3, 1e-3), "r_z": (5e-3, 9e-3)},
    ),
    Known(
        "broad_18", ("reference_frame",), True,
        "tracked body and unit are turned by 0.1 to 0.3° against each other", POSES,
    ),
    Known(
        "ln100_two_position", ("earth_rotation",), True,
        "half the difference of up and down is 11.733 °/h, Earth's vertical part there 11.702",
        "means of both rests, by hand",
    ),
    Known(
        "ln100_two_position", EVERYTHING, False,
        "beside Earth's rotation nothing of note is in it", "means of both rests, by hand",
    ),
    Known(
        "vn200_57630_six_position", ("axis_mapping",), True,
        "x reads −9.80 m/s² where +x is said to point up and +9.78 where −x is, y −9.78 and +9.80: "
        "both against what is told, z as it is told",
        "means of the rests, by hand",
    ),
    Known(
        "adi_mems_two_position", ("earth_rotation",), False,
        "noise of 3.3e-3 °/s over a rest hides Earth's rotation", "scatter of the rests, by hand",
    ),
)  # fmt: skip


# Whether a claim of explain's JSON is right, wrong or not known, and the figure for or against.

Judgement = Literal["right", "wrong", "not known"]
Parameters = Sequence[Mapping[str, Any]]

BY_TRUTH: dict[str, Judgement] = {
    "true": "right", "false": "wrong", "cannot tell": "not known",
}  # fmt: skip


@dataclass(frozen=True)
class Judged:
    """One finding with a name, or an unnamed one that the hand has tried.

    response: name, group and first size. share: of the mismatch that it removes. evidence: the
    figure for or against, and where it is from.
    """

    recording: str
    response: str
    share: float | None
    judgement: Judgement
    evidence: str


def judged(
    recording: str, answer: Answer, known: Sequence[Known], tried: Sequence[Claim]
) -> list[Judged]:
    """Every claim of an answer; findings without a name only where the hand has tried them.

    tried: claims on this recording that were tried by hand.
    """
    own = [fact for fact in known if fact.recording == recording]
    found = []
    for finding in answer.get("findings", ()):
        judgement, evidence = _by_facts(finding, answer, own)
        if judgement == "not known":
            by_hand = [one for one in tried if one.made({"findings": [_plain(finding)]})]
            if by_hand:
                judgement, evidence = BY_TRUTH[by_hand[0].truth], by_hand[0].evidence
        if finding["effect"] == "unnamed" and judgement == "not known":
            continue
        found.append(
            Judged(recording, response(finding), finding.get("share"), judgement, evidence)
        )
    return found


def response(finding: Mapping[str, Any]) -> str:
    """The name, what it is told together with, and the first size."""
    words = in_words([finding])
    others = [name for name in finding.get("group") or () if name != finding["effect"]]
    if finding["effect"] == "unnamed" and finding.get("follows"):
        words = f"unnamed: {finding['follows']['en']}"
    return words + (f" (or {', '.join(others)})" if others else "")


def _by_facts(
    finding: Mapping[str, Any], answer: Answer, facts: Sequence[Known]
) -> tuple[Judgement, str]:
    names = {finding["effect"], *(finding.get("group") or ())}
    if names == {"unnamed"}:
        return "not known", ""
    about = [fact for fact in facts if names & set(fact.names)]
    about = about or [fact for fact in facts if fact.names == EVERYTHING]
    if not about:
        return "not known", "nothing was measured by hand that would decide it"
    fact = next((one for one in about if one.there), about[0])
    evidence = f"{fact.fact} ({fact.source})"
    if fact.there is None:
        return "not known", evidence
    if not fact.there:
        return "wrong", evidence
    if _agrees(finding, answer, fact):
        return "right", evidence
    return "wrong", f"the name is right, its size is not: {evidence}"


def _agrees(finding: Mapping[str, Any], answer: Answer, fact: Known) -> bool:
    """Whether what is stated, with its U, reaches into the range of every parameter known."""
    together = [finding]
    if fact.names == DELAYS:
        together = [one for one in answer["findings"] if one["effect"] in DELAYS] or together
    stated = [
        each
        for one in together
        for each in (*one["parameters"], *one.get("common", ()))
        if each["name"] in fact.within
    ]
    if fact.names == DELAYS:
        return not stated or _reaches(stated, *next(iter(fact.within.values())))
    return all(_reaches([each], *fact.within[each["name"]]) for each in stated)


def _reaches(stated: Parameters, low: float, high: float) -> bool:
    """Whether the sum of some parameters ± U (k = 2) reaches into a range."""
    value = sum(float(each["value"]) for each in stated)
    expanded = 2.0 * sum(float(each["u"]) ** 2 for each in stated) ** 0.5
    return low - expanded <= value <= high + expanded


def _plain(finding: Mapping[str, Any]) -> Mapping[str, Any]:
    """A finding as the blind answers have it, whose `follows` is plain text."""
    follows = finding.get("follows")
    return {**finding, "follows": follows["en"] if follows else None}


# Explains every recording in a process of its own and measures what that costs.

MIB = 1024.0  # of ru_maxrss
THREADS = {"OPENBLAS_NUM_THREADS": "1"}  # so that processor time is that of one core


@dataclass(frozen=True)
class Cost:
    """Processor time, s, and the largest memory, MiB, of one explanation, from its start."""

    seconds: float
    memory: float


def explained(recording: Path, out: Path) -> tuple[Mapping[str, Any] | None, Cost]:
    """explain's JSON, kept in out/, and its cost; None where it refuses the recording."""
    environment = {**os.environ, **THREADS, "MIMUCAL_HOME": str(out / "home" / recording.name)}
    answer = out / f"{recording.name}.json"
    with answer.open("w", encoding="utf-8") as kept:
        ordered = [sys.executable, "-m", "flows.cli", "explain", str(recording), "--json"]
        process = subprocess.Popen(ordered, stdout=kept, env=environment)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    cost = Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / MIB)
    text = answer.read_text(encoding="utf-8")
    return (json.loads(text) if process.returncode == 0 else None), cost


# The page of all claims on real recordings.

HEAD = ("recording", "explain says (± u)", "share", "judgement", "the figure for or against")
FACTS = (
    "what is there", "recording", "by hand", "a second way", "not known", "explain says", "",
)  # fmt: skip
COSTS = ("recording", "s", "MiB", "explained share", "unnamed")


@dataclass(frozen=True)
class Answered:
    """One recording: what explain said of it, how that is judged, and what it cost."""

    recording: str
    answer: Mapping[str, Any] | None
    claims: tuple[Judged, ...]
    cost: Cost


def markdown(every: Sequence[Answered], facts: Sequence[Fact], code_version: str) -> str:
    """Counts, all claims, what is there by hand, and what each recording cost."""
    answered = {one.recording: one.answer for one in every}
    claims = [claim for one in every for claim in one.claims]
    counts = Counter(claim.judgement for claim in claims)
    shown = (f"{counts[word]} {word}" for word in ("right", "wrong", "not known"))
    return "\n".join([
        "# Every claim on every real recording", "",
        "Each named finding of explain, held against what the recording's makers document and "
        "what was measured on it by hand. A claim is wrong where the effect is not there, or where "
        "its size with U misses what was measured.", "",
        f"{len(claims)} claims: {', '.join(shown)}.", "",
        *table(HEAD, map(_claim, claims)), "",
        "## What is there by hand, in two ways", "",
        *table(FACTS, (_fact(fact, answered) for fact in facts)), "",
        "Processor time of one core and largest memory, start of the program included.", "",
        *table(COSTS, map(_cost, every)), "", f"{code_version}.", "",
    ])  # fmt: skip


def _claim(claim: Judged) -> tuple[str, ...]:
    share = "—" if claim.share is None else f"{100.0 * claim.share:.0f} %"
    return (claim.recording, claim.response, share, claim.judgement, claim.evidence)


def _fact(fact: Fact, answered: Mapping[str, Answer | None]) -> tuple[str, ...]:
    refused = {"failed": "refused"}
    said = [fact.declared(answered.get(name) or refused) for name in fact.recordings]
    ways = (f"{how}: {size}" for how, size in zip(fact.how, fact.size, strict=True))
    return (
        fact.what, ", ".join(fact.recordings), *ways, fact.unknown,
        "; ".join(each.words for each in said), "; ".join(each.outcome for each in said),
    )  # fmt: skip


def _cost(one: Answered) -> tuple[object, ...]:
    answer, unnamed = one.answer, 0
    share = "refused"
    if answer is not None:
        share = f"{100.0 * answer['explained_share']:.0f} %"
        unnamed = sum(each["effect"] == "unnamed" for each in answer["findings"])
    return one.recording, f"{one.cost.seconds:.1f}", f"{one.cost.memory:.0f}", share, unnamed


def stated(
    folders: Annotated[list[Path], typer.Argument(help="Folders that hold recordings.")],
    out: Out = None, minutes: Minutes = None, write: Write = False,
) -> None:  # fmt: skip
    """Every claim of `explain` about real recordings, judged by what is known of them."""
    own = folder_of("stated", out)
    found = sorted(path.parent for folder in folders for path in folder.glob("*/manifest.json"))
    by_name = {path.name: path for path in found}
    recordings = {name: read_folder(by_name[name]) for name in RECORDINGS}
    tried = doubtful(recordings)
    every = []
    explained_ = answers("stated", by_name, partial(explained, out=own), own, minutes=minutes)
    for name, (answer, cost) in explained_.items():
        claims = [claim for claim in tried if claim.recording == name]
        judgements = tuple(judged(name, answer or {}, KNOWN, claims))
        every.append(Answered(name, answer, judgements, cost))
    publish("stated", markdown(every, facts_of(recordings), code_version()), own, write)
