"""What is known of the real recordings by their makers and by hand, beside what explain says."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from storage.formats.folder import read_folder
from tasks.version import code_version
from tests.proof.real.facts import RECORDINGS, Answer, Claim, doubtful, in_words
from tests.proof.study import EVIDENCE, Minutes, Out, Write, answers, folder_of, publish, table

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

    response: name, group and first size. share: of the mismatch that it removes; None where an
    older answer does not state it. evidence: the figure for or against, and where it is from.
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
                judgement, evidence = BY_TRUTH[by_hand[0].truth], by_hand[0].evidence.en
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


def explained(
    recording: Path, out: Path, program: Sequence[str] = (sys.executable, "-m", "flows.cli")
) -> tuple[Mapping[str, Any] | None, Cost]:
    """explain's JSON, kept in out/, and its cost; None where it refuses the recording."""
    environment = {**os.environ, **THREADS, "MIMUCAL_HOME": str(out / "home" / recording.name)}
    answer = out / f"{recording.name}.json"
    with answer.open("w", encoding="utf-8") as kept:
        ordered = [*program, "explain", str(recording), "--json"]
        process = subprocess.Popen(ordered, stdout=kept, env=environment)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    cost = Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / MIB)
    text = answer.read_text(encoding="utf-8")
    return (json.loads(text) if process.returncode == 0 else None), cost


# The page of all claims on real recordings, as Markdown and as data.

HEAD = ("recording", "explain says (± u)", "share", "judgement", "the figure for or against")
COSTS = ("recording", "s before", "s now", "MiB before", "MiB now", "explained share", "unnamed")


@dataclass(frozen=True)
class Answered:
    """One recording: what explain said of it and what that cost; before: an older engine's cost."""

    recording: str
    answer: Mapping[str, Any] | None
    claims: tuple[Judged, ...]
    cost: Cost
    before: Cost | None


def markdown(every: Sequence[Answered], code_version: str) -> str:
    """Counts, all claims, and what each recording cost."""
    claims = [claim for one in every for claim in one.claims]
    counts = {
        word: sum(claim.judgement == word for claim in claims)
        for word in ("right", "wrong", "not known")
    }
    return "\n".join([
        "# Every claim on every real recording", "",
        "Each named finding of explain, held against what the recording's makers document and "
        "what was measured on it by hand. A claim is wrong where the effect is not there, or where "
        "its size with U misses what was measured.", "",
        f"{len(claims)} claims: " + ", ".join(f"{n} {word}" for word, n in counts.items()) + ".",
        "", *table(HEAD, [_claim(claim) for claim in claims]), "",
        "Processor time of one core and largest memory, start of the program included; before: "
        "commit 230cf52.", "", *table(COSTS, [_cost(one) for one in every]), "",
        f"{code_version}.", "",
    ])  # fmt: skip


def data(every: Sequence[Answered], code_version: str) -> dict[str, Any]:
    """`mimu-stated-real/1`."""
    return {
        "format": "mimu-stated-real/1",
        "code_version": code_version,
        "recordings": [
            {
                "recording": one.recording,
                "verdict": one.answer and one.answer["verdict"],
                "claims": [asdict(claim) for claim in one.claims],
                "cost": asdict(one.cost),
                "before": one.before and asdict(one.before),
            }
            for one in every
        ],
    }


def _claim(claim: Judged) -> tuple[str, ...]:
    share = "—" if claim.share is None else f"{100.0 * claim.share:.0f} %"
    return (claim.recording, claim.response, share, claim.judgement, claim.evidence)


def _cost(one: Answered) -> tuple[str, ...]:
    before, now = one.before, one.cost
    declared = one.answer or {}
    share = declared.get("explained_share")
    unnamed = sum(each["effect"] == "unnamed" for each in declared.get("findings", ()))
    return (
        one.recording,
        "—" if before is None else f"{before.seconds:.1f}",
        f"{now.seconds:.1f}",
        "—" if before is None else f"{before.memory:.0f}",
        f"{now.memory:.0f}",
        "refused" if one.answer is None else "—" if share is None else f"{100.0 * share:.0f} %",
        str(unnamed),
    )


def stated(
    folders: Annotated[list[Path], typer.Argument(help="Folders that hold recordings.")],
    before: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Costs of an older engine, a line of JSON each: "
                     "recording, seconds, memory."),
    ] = None,
    out: Out = None, minutes: Minutes = None, write: Write = False,
) -> None:  # fmt: skip
    """Every claim of `explain` about real recordings, judged by what is known of them."""
    own = folder_of("stated", out)
    found = sorted(path.parent for folder in folders for path in folder.glob("*/manifest.json"))
    by_name = {path.name: path for path in found}
    tried = doubtful({name: read_folder(by_name[name]) for name in RECORDINGS})
    older = {} if before is None else dict(map(_older_cost, before.read_text().splitlines()))
    every = []
    explained_ = answers("stated", by_name, partial(explained, out=own), own, minutes=minutes)
    for name, (answer, cost) in explained_.items():
        claims = [claim for claim in tried if claim.recording == name]
        every.append(Answered(name, answer, tuple(judged(name, answer or {}, KNOWN, claims)),
                              cost, older.get(name)))  # fmt: skip
    version = code_version()
    response = json.dumps(data(every, version), indent=1, ensure_ascii=False) + "\n"
    for place in (own, *([EVIDENCE] if write else [])):
        (place / "stated.json").write_text(response, encoding="utf-8")
    publish("stated", markdown(every, version), own, write)


def _older_cost(line: str) -> tuple[str, Cost]:
    read = json.loads(line)
    return read["recording"], Cost(read["seconds"], read["memory"])
