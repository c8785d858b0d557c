"""The value by hand of what explain may state of a recording: an own fit, or what is documented.

Nothing of `tasks.explain` is used.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import typer
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording
from storage.formats.folder import read_folder
from tasks.explain import explain
from tasks.explain.explanation import Finding
from tasks.version import code_version
from tasks.words import say
from tests.proof.real.hand.measured import Measured, strongest
from tests.proof.real.hand.poses import by_poses
from tests.proof.real.hand.rests import vertical_earth_rate
from tests.proof.real.hand.shaft import delay_by_angle, delay_by_phase
from tests.proof.study import EVIDENCE, Minutes, Out, Write, folder_of, hold, table

UNKNOWN_SCALE = 0.01  # of accelerometers of which gravity was taken
FIT = "least squares on the poses, four parts in four bands"
Key = tuple[str, str]  # effect, parameter


@dataclass(frozen=True)
class ByHand:
    """A value by hand and how it came about."""

    value: Measured
    how: str


def by_hand(name: str, recording: Recording) -> Mapping[Key, ByHand]:
    """What is known of a recording in a folder of this name, by effect and parameter."""
    found = dict[Key, ByHand]()
    if recording.table is None and recording.reference is not None:
        found |= _of_poses(recording)
    if recording.table is not None and set(recording.table.columns) == {"shaft_angle"}:
        phase, angle = delay_by_phase(recording), delay_by_angle(recording)
        both = Measured(
            phase.value, float(np.hypot(phase.u, 0.5 * (angle.value - phase.value))), "s"
        )
        found["time_offset", "seconds"] = ByHand(both, "phase of the gyro against the encoder")
    if recording.manifest.station.latitude_deg is not None:
        vertical = vertical_earth_rate(recording)
        found["earth_rotation", "vertical_rate"] = ByHand(vertical, "latitude")
    if name == "gravity_removed":
        found |= dict(_lever_by_gyros(recording))
    if name == "adi_mems_two_position":
        found["mains_pickup", "frequency"] = ByHand(_mains(recording), "strongest line, folded")
    return found | {
        (effect, parameter): ByHand(Measured(value, u, unit), how)
        for own, effect, parameter, value, u, unit, how in DOCUMENTED
        if own == name
    }


def _of_poses(recording: Recording) -> dict[Key, ByHand]:
    found = by_poses(recording)
    names: dict[str, Key] = {
        "seconds": ("time_offset", "seconds"),
        **{f"r_{a}": ("lever_arm", f"r_{a}") for a in "xyz"},
        "lean_x": ("reference_frame", "tilt_east"), "lean_y": ("reference_frame", "tilt_north"),
    }  # fmt: skip
    values = {key: found[name] for name, key in names.items() if np.isfinite(found[name].value)}
    return {
        key: ByHand(
            Measured(np.radians(each.value), np.radians(each.u), "rad")
            if each.unit == "deg" else each,
            FIT,
        )
        for key, each in values.items()
    }  # fmt: skip


def _lever_by_gyros(recording: Recording) -> Iterator[tuple[Key, ByHand]]:
    """Of accelerometers without gravity: what their readings owe to the gyros, below 5 Hz."""
    imu = recording.imu
    rate = 1.0 / float(np.median(np.diff(imu.t)))
    low = butter(4, 5.0, fs=rate, output="sos")
    gyro = imu.stack(GYRO)
    change = CubicSpline(imu.t, gyro)(imu.t, 1)
    made = [np.cross(change, r) + np.cross(gyro, np.cross(gyro, r)) for r in np.eye(3)]
    ones = np.ones(len(gyro))
    columns = np.stack([*made, *(np.outer(ones, axis) for axis in np.eye(3))], axis=2)
    columns, read = (sosfiltfilt(low, each, axis=0) for each in (columns, imu.stack(ACCEL)))
    parts = [
        np.linalg.lstsq(A.reshape(-1, 6), y.ravel(), rcond=None)[0]
        for A, y in zip(np.array_split(columns, 6), np.array_split(read, 6), strict=True)
        if np.abs(A[:, :, :3]).max() > 0.5
    ]
    for k, name in enumerate(("r_x", "r_y", "r_z")):
        each = [part[k] for part in parts]
        scatter = float(np.std(each, ddof=1) / np.sqrt(len(each)))
        u = float(np.hypot(scatter, UNKNOWN_SCALE * np.mean(each)))
        yield ("lever_arm", name), ByHand(Measured(float(np.mean(each)), u, "m"),
                                          "least squares on the gyros")  # fmt: skip


def _mains(recording: Recording) -> Measured:
    """The strongest line of an accelerometer near 40 Hz, which 60 Hz is at 100 Hz."""
    imu = recording.imu
    rate = 1.0 / float(np.median(np.diff(imu.t)))
    first = slice(0, int(30.0 * rate))
    each = [rate - strongest(imu.t[first], imu.columns[name][first], 38.0, 42.0) for name in ACCEL]
    return Measured(float(np.mean(each)), float(np.std(each, ddof=1) + 1.0 / 30.0 / 4.0), "Hz")


FIRMWARE = "256 counts, by the firmware's joining of two bytes"
SETTING = "documented"
GRAVITY = 9.80665
LOW_BYTE = ("low_byte_signed", "low_byte_signed_or", "low_byte_signed_no_table",
            "low_byte_signed_25hz")  # fmt: skip
DOCUMENTED: tuple[tuple[str, str, str, float, float, str, str], ...] = (
    *(("bmi160_board1", "code_fault", f"jump_gyro_{a}", np.radians(256 / 262.4), 1e-6, "rad/s",
       FIRMWARE) for a in "xyz"),
    *(("bmi160_board1", "code_fault", f"jump_accel_{a}", 256 / 16384 * GRAVITY, 1e-6, "m/s2",
       FIRMWARE) for a in "xyz"),
    *((name, "code_fault", f"jump_gyro_{a}", np.radians(1.953125), 1e-5, "rad/s", FIRMWARE)
      for name in LOW_BYTE for a in "xyz"),
    *((name, "code_fault", f"jump_accel_{a}", 0.306, 5e-4, "m/s2", FIRMWARE)
      for name in LOW_BYTE for a in "xyz"),
    ("arrival_stamps_16ms", "time_offset", "seconds", 9.44e-3, 5e-6, "s",
     "as the packets were made"),
    ("gyro_range_1137", "range_setting", "factor", 130.0 / 114.3, 0.0, "1", SETTING),
    ("gravity_removed", "gravity_removed", "at_rest", 0.06, 0.005, "m/s2", SETTING),
    ("gyro_z_inverted_labels_only", "axis_mapping", "zz", -1.0, 0.0, "1", SETTING),
    ("vn200_57630_six_position", "axis_mapping", "xx", -1.0, 0.0, "1", "means of the rests"),
    ("vn200_57630_six_position", "axis_mapping", "yy", -1.0, 0.0, "1", "means of the rests"),
    *(("sunsided_turns", "axis_mapping", f"{a}{a}", -1.0, 0.0, "1", SETTING) for a in "xyz"),
    *((name, "coarse_quantisation", "accel", 0.0980665, 1e-7, "m/s2", "values that occur")
      for name in ("encoder_mpu6050_pitch_slow", "encoder_roll_slow", "encoder_yaw_fast")),
)  # fmt: skip

OTHERS = "SOURCE.md of the recording"
# Measured by hand by those who brought the recordings, before any of this: recording, effect,
# parameter, value, u as far as they state one, unit.
BY_OTHERS: tuple[tuple[str, str, str, float, float, str], ...] = (
    ("ring_trial1_seg5", "time_offset", "seconds", -16.1e-3, 0.0, "s"),
    ("ring_trial1_seg5", "lever_arm", "r_x", 111.9e-3, 0.1e-3, "m"),
    ("ring_trial1_seg5", "lever_arm", "r_y", 76.8e-3, 0.1e-3, "m"),
    ("ring_trial1_seg5", "lever_arm", "r_z", 11.3e-3, 0.1e-3, "m"),
    ("phone_basic_motions", "time_offset", "seconds", 45.2e-3, 0.0, "s"),
    ("phone_basic_motions", "lever_arm", "r_x", 17.8e-3, 0.0, "m"),
    ("phone_basic_motions", "lever_arm", "r_y", 53.3e-3, 0.0, "m"),
    ("phone_basic_motions", "lever_arm", "r_z", 20.4e-3, 0.0, "m"),
    ("broad_18", "time_offset", "seconds", 4.15e-3, 0.05e-3, "s"),
    ("broad_18", "lever_arm", "r_x", 2.8e-3, 1e-3, "m"),
    ("broad_18", "lever_arm", "r_y", -1.5e-3, 1e-3, "m"),
    ("broad_18", "lever_arm", "r_z", 7.3e-3, 1e-3, "m"),
    ("encoder_roll_slow", "time_offset", "seconds", 11e-3, 0.5e-3, "s"),
    ("encoder_yaw_fast", "time_offset", "seconds", 12e-3, 0.25e-3, "s"),
    ("ln100_two_position", "earth_rotation", "vertical_rate", 11.733, 0.0, "deg/h"),
)  # fmt: skip


def by_others(name: str) -> Mapping[Key, ByHand]:
    """What others measured of a recording, by effect and parameter."""
    return {
        (effect, parameter): ByHand(Measured(value, u, unit), OTHERS)
        for own, effect, parameter, value, u, unit in BY_OTHERS
        if own == name
    }


# Explains a recording, and keeps of the answer what the page of values shows.


def explained(recording: Recording) -> dict[str, Any]:
    """The answer as data; a recording that explain refuses with what it says of it."""
    try:
        found = explain.explain(recording)
    except Unusable as refusal:
        return {"refused": str(refusal), "findings": []}
    return {
        "verdict": found.verdict,
        "p_value": found.p_value,
        "explained_share": found.explained_share,
        "findings": [_finding(one) for one in found.findings],
        "remarks": [say(remark, "en") for remark in found.remarks],
    }


def _finding(one: Finding) -> dict[str, Any]:
    return {
        "effect": one.effect,
        "group": [name for name in one.group if name != one.effect],
        "behaviour": say(one.behaviour or one.title, "en"),
        "refused": one.refusal and f"{one.refusal.name}, {one.refusal.kind}",
        "share": one.share,
        "parameters": [each.model_dump() for each in one.parameters],
    }


# The page of values: one row for each parameter of each named finding.

COVERAGE = 2.0
Holds = Literal["yes", "both", "no", "—"]
IN = {"rad": ("deg", 57.29578), "m": ("mm", 1e3), "s": ("ms", 1e3)}


@dataclass(frozen=True)
class Row:
    """A parameter that explain states. holds: its U holds the value by hand; both: only with the
    U of that value.
    """

    recording: str
    effect: str
    parameter: str
    stated: str
    hand: str
    how: str
    holds: Holds


@dataclass(frozen=True)
class Explained:
    """An answer (`run.explained`), and what is known by hand, here and by others."""

    name: str
    answer: Mapping[str, Any]
    hand: Mapping[Key, ByHand]
    others: Mapping[Key, ByHand] = field(default_factory=dict)

    def rows(self) -> list[Row]:
        """Beside the values by hand."""
        return self._beside(self.hand)

    def rows_by_others(self) -> list[Row]:
        """Those that others measured."""
        return [row for row in self._beside(self.others) if row.holds != "—"]

    def _beside(self, hand: Mapping[Key, ByHand]) -> list[Row]:
        found = []
        for finding in self.answer.get("findings", ()):
            if finding["effect"] == "unnamed":
                continue
            found += [self._row(finding, each, hand) for each in finding["parameters"]]
        return found

    def _row(
        self, finding: Mapping[str, Any], each: Mapping[str, Any], known: Mapping[Key, ByHand]
    ) -> Row:
        effect, parameter = finding["effect"], each["name"]
        names = (effect, *finding.get("group", ()))
        hand = next(
            (known[n, parameter] for n in names if (n, parameter) in known), None
        )  # fmt: skip
        unit, times = IN.get(each["unit"], (each["unit"], 1.0))
        value, U = times * each["value"], times * COVERAGE * each["u"]
        stated = f"{value:.5g} ± {U:.2g} {unit}"
        name = effect if len(names) == 1 else f"{effect} (or {', '.join(names[1:])})"
        if hand is None:
            return Row(self.name, name, parameter, stated, "—", "—", "—")
        own, expanded = times * hand.value.value, times * COVERAGE * hand.value.u
        off = abs(value - own)
        holds: Holds = "yes" if off <= U + 1e-9 * abs(own) else "no"
        if holds == "no" and off <= (U**2 + expanded**2) ** 0.5:
            holds = "both"
        return Row(
            self.name, name, parameter, stated, f"{own:.5g} ± {expanded:.2g}", hand.how, holds
        )


def markdown(every: Sequence[Explained], code_version: str) -> str:
    """Counts first, then all rows, then the recordings without a name."""
    rows = [row for one in every for row in one.rows()]
    others = [row for one in every for row in one.rows_by_others()]
    judged = [row for row in rows if row.holds != "—"]
    findings: dict[tuple[str, str], set[Holds]] = {}
    for row in judged:
        findings.setdefault((row.recording, row.effect), set()).add(row.holds)
    alone = sum(held == {"yes"} for held in findings.values())
    both = sum("no" not in held for held in findings.values())
    lines = [
        "# Values on every real recording", "",
        "Each parameter of each named finding of `explain` with U (k = 2), beside the value by "
        "hand with its own U: an independent fit (`tests/proof/real/hand`), or what the "
        "recording's origin documents. A finding holds where all of its parameters do: by its U "
        "alone (yes), or with that of the value by hand (both).", "",
        f"{len(findings)} findings have a value by hand: {alone} hold by their U alone, {both} "
        f"with that by hand. Of {len(judged)} parameters {sum(r.holds == 'yes' for r in judged)} "
        f"and {sum(r.holds != 'no' for r in judged)}. {len(rows) - len(judged)} stated parameters "
        "have none by hand.", "",
        *_table(rows), "",
        "## Beside what others measured", "",
        "By hand by those who brought the recordings, before and without the fits above: "
        f"{sum(r.holds == 'yes' for r in others)} of {len(others)} parameters hold by their U "
        f"alone, {sum(r.holds != 'no' for r in others)} with that by hand where one is stated.",
        "", *_table(others), "",
        "## Verdicts", "",
        *table(("recording", "verdict", "explained", "without a name, or refused"),
               map(_verdict, every)), "", f"{code_version}.", "",
    ]  # fmt: skip
    return "\n".join(lines)


def _table(rows: Sequence[Row]) -> list[str]:
    columns = ("recording", "effect", "parameter", "value ± U", "by hand ± U", "by hand, how",
               "holds")  # fmt: skip
    return table(columns, (vars(row).values() for row in rows))


def _verdict(one: Explained) -> tuple[str, ...]:
    answer = one.answer
    if "refused" in answer:
        return one.name, f"not explained: {answer['refused']}", "", ""
    unnamed = [
        each["behaviour"] + (f" (refused: {each['refused']})" if each["refused"] else "")
        for each in answer["findings"] if each["effect"] == "unnamed"
    ]  # fmt: skip
    share = f"{100.0 * answer['explained_share']:.0f} %"
    return one.name, answer["verdict"], share, "; ".join(unnamed) or "—"


def values(
    folders: Annotated[list[Path], typer.Argument(help="Folders that hold recordings.")],
    out: Out = None, minutes: Minutes = None, write: Write = False,
) -> None:  # fmt: skip
    """What `explain` states of real recordings, beside the values by hand and those of others."""
    found = (path.parent for folder in folders for path in folder.glob("*/manifest.json"))
    work = {path.name: path for path in sorted(found)}
    hold("real-values", work, _beside_hand, lambda every: markdown(every, code_version()), out,
         minutes=minutes)  # fmt: skip
    if write:
        page = (folder_of("real-values", out) / "real-values.md").read_text(encoding="utf-8")
        (EVIDENCE / "real.md").write_text(page, encoding="utf-8")


def _beside_hand(path: Path) -> Explained:
    """An answer beside the values by hand, which take longer than an explanation."""
    recording = read_folder(path)
    answer = explained(recording)
    named = any(one["effect"] != "unnamed" for one in answer["findings"])
    hand = by_hand(path.name, recording) if named else {}
    return Explained(path.name, answer, hand, by_others(path.name))
