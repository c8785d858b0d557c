"""Something that is known of a real recording, and what an answer of `explain` says of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from schemas.recording import ACCEL, Recording
from tests.proof.real.hand.measured import (
    Measured,
    amplitude,
    dead_zone_misfit,
    prominence,
    step_of,
    strongest,
)
from tests.proof.real.hand.rests import (
    CHANNELS,
    half_difference,
    means_of,
    misfit,
    readings,
    rests,
    ripple,
    together,
    vertical_earth_rate,
    wander,
    waves_per_turn,
)
from tests.proof.real.hand.shaft import (
    corner,
    delay_by_angle,
    delay_by_gravity,
    delay_by_pattern,
    delay_by_phase,
    excursion,
    jump_at,
    line_shared,
)

Answer = Mapping[str, Any]  # answer.json of tests.proof.trial.blind
Recordings = Mapping[str, Recording]
Truth = Literal["true", "false", "cannot tell"]


@dataclass(frozen=True)
class Fact:
    """An effect that is really there, shown by hand in two ways.

    how, size: of each of the two ways. unknown: what they do not tell. names: of the catalogue
    that would be right. declared: what an answer says of it, and whether that is right, wrong or
    silent.
    """

    key: str
    recordings: tuple[str, ...]
    what: str
    how: tuple[str, str]
    size: tuple[str, str]
    unknown: str
    declared: Callable[[Answer], "Judged"]


@dataclass(frozen=True)
class Judged:
    """What an answer says of a fact: in words, and whether it is right."""

    words: str
    outcome: Literal["right", "right name, value off", "wrong", "silent", "explain failed"]


@dataclass(frozen=True)
class Claim:
    """Something that explain says, or said once, of a recording, tried by hand.

    made: whether an answer makes it. evidence: the numbers of the trial by hand.
    """

    recording: str
    what: str
    truth: Truth
    evidence: str
    made: Callable[[Answer], bool]


def findings(answer: Answer, *effects: str, channel: str = "") -> list[Mapping[str, Any]]:
    """The findings of some names, seen in a channel if one is asked for."""
    return [
        each
        for each in answer.get("findings", ())
        if each["effect"] in effects and (not channel or channel in each["channels"])
    ]


def parameter(finding: Mapping[str, Any], name: str) -> tuple[float, float] | None:
    """Value and u of the first parameter of a name."""
    for each in finding["parameters"]:
        if each["name"] == name:
            return float(each["value"]), float(each["u"])
    return None


def lines_at(answer: Answer, frequency: float, within: float) -> list[Mapping[str, Any]]:
    """The findings with a frequency near one, Hz."""
    return [
        each
        for each in answer.get("findings", ())
        if (response := parameter(each, "frequency")) and abs(response[0] - frequency) < within
    ]


def in_words(some: Sequence[Mapping[str, Any]]) -> str:
    """Names and first parameters, as explain states them."""
    response = []
    for each in some:
        stated = [p for p in each["parameters"] if p["u"] > 0.0][:1]
        numbers = "".join(f" {p['value']:.4g} ± {p['u']:.2g} {p['unit']}" for p in stated)
        response.append(f"{each['effect']}{numbers}")
    return "; ".join(response) or "—"


def silent(answer: Answer) -> Judged:
    """Nothing is said; a failure of explain is said as one, by its first line."""
    if "failed" in answer:
        return Judged(answer["failed"].splitlines()[0], "explain failed")
    return Judged("—", "silent")


# Units at rest, up and down: Earth's rotation, and lines in the spectrum.

RING_LASER, MEMS = "ln100_two_position", "adi_mems_two_position"
NEAR_NYQUIST = (28.0, 31.9)  # Hz


def two_positions(recordings: Recordings) -> list[Fact]:
    """What the two stationary recordings hold."""
    return [
        _earth(recordings),
        _no_earth(recordings),
        _mains(recordings),
        _strongest_line(recordings),
    ]


def _earth(recordings: Recordings) -> Fact:
    observation = half_difference(recordings[RING_LASER], 0)
    known = vertical_earth_rate(recordings[RING_LASER])

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "earth_rotation")
        value = parameter(response[0], "vertical_rate") if response else None
        if value is None:
            return silent(answer)
        right = abs(value[0] - known.value) <= 2.0 * value[1]
        return Judged(in_words(response), "right" if right else "right name, value off")

    return Fact(
        "earth",
        (RING_LASER,),
        "Earth's rotation",
        (
            "half of gyro x up less down; u by batches",
            "15.041 deg/h · sin(latitude told)",
        ),
        (str(observation), str(known)),
        (
            "two positions show only the vertical part, and would show a g-sensitivity of the same "
            "size alike: the agreement with the latitude is what speaks for Earth"
        ),
        declared,
    )


def _no_earth(recordings: Recordings) -> Fact:
    recording = recordings[MEMS]
    observation, known = half_difference(recording, 0), vertical_earth_rate(recording)

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "earth_rotation")
        if "failed" in answer:
            return silent(answer)
        return Judged(in_words(response), "wrong" if response else "right")

    return Fact(
        "no_earth",
        (MEMS,),
        "Earth's rotation cannot be seen",
        (
            "half of gyro x up less down; u by batches",
            "15.041 deg/h · sin(latitude told)",
        ),
        (str(observation), str(known)),
        (
            "what is seen has the other sign: g-sensitivity or a bias that moved between the "
            "positions, which two positions do not separate"
        ),
        declared,
    )


def _mains(recordings: Recordings) -> Fact:
    recording = recordings[MEMS]
    observation = []
    for rest in rests(recording):
        t, values = readings(recording, rest)
        at = strongest(t, values[:, 3], 39.0, 41.0)
        observation.append(f"{at:.4f} Hz, {1e3 * amplitude(t, values[:, 3], at):.1f} mm/s²")

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "mains_pickup")
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "mains",
        (MEMS,),
        "a line at 40 Hz in the accelerometers: mains of 60 Hz, folded at 100 Hz",
        (
            "spectrum of accelerometer x, x up",
            "the same with x down, a minute later",
        ),
        (observation[0], observation[1]),
        (
            "40, 60 and 140 Hz look alike at 100 Hz; that it keeps to 60 Hz within 2e-4, in a land "
            "with 60 Hz, speaks for the mains, not its way in"
        ),
        declared,
    )


def _strongest_line(recordings: Recordings) -> Fact:
    recording = recordings[RING_LASER]
    observation, places = [], []
    for rest in rests(recording):
        t, values = readings(recording, rest)
        at = strongest(t, values[:, 2], *NEAR_NYQUIST)
        places.append(at)
        size = np.degrees(amplitude(t, values[:, 2], at))
        observation.append(f"{at:.3f} Hz, {size:.4f} deg/s")

    def declared(answer: Answer) -> Judged:
        response = [each for at in places for each in lines_at(answer, at, 0.1)]
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "strongest_line",
        (RING_LASER,),
        "its strongest line, in all three gyros, moves between the positions",
        (
            "spectrum of gyro z, x up",
            "the same with x down",
        ),
        (observation[0], observation[1]),
        "sampled at 64 Hz, anything below 32 Hz may be folded: the source is not told",
        declared,
    )


# The MPU-6050 on a stepper's shaft with an optical encoder.

SHAFT = "encoder_mpu6050_pitch_slow"
DATASHEET = Measured(42.0, 4.0, "Hz")  # MPU-6050 register map, DLPF_CFG 3, of a higher order


def on_shaft(recordings: Recordings) -> list[Fact]:
    """What the encoder rig holds."""
    return [
        _gyro_delay(recordings),
        _gravity_delay(recordings),
        _low_pass(recordings),
        _rounding(recordings),
    ]


def total_delay(answer: Answer) -> tuple[float, float] | None:
    """The delay, s, and its u, that an answer states: clock shift and low-pass together."""
    stated = [
        value
        for each in findings(answer, "time_offset", "bandwidth")
        for name in ("seconds", "time_constant")
        if (value := parameter(each, name))
    ]
    if not stated:
        return None
    return sum(value for value, _ in stated), float(np.linalg.norm([u for _, u in stated]))


def _judged_delay(answer: Answer, known: Measured) -> Judged:
    stated = total_delay(answer)
    if stated is None:
        return silent(answer)
    right = Measured(*stated, "s").agrees(known)
    words = in_words(findings(answer, "time_offset", "bandwidth"))
    return Judged(words, "right" if right else "right name, value off")


def _gyro_delay(recordings: Recordings) -> Fact:
    recording = recordings[SHAFT]
    by_angle = delay_by_angle(recording)
    return Fact(
        "gyro_delay",
        (SHAFT,),
        "the gyro is late against the encoder",
        (
            "phase of the cross spectrum, 1 to 13 Hz",
            "lag at which the summed gyro follows the encoder's angle best",
        ),
        (str(delay_by_phase(recording)), str(by_angle)),
        (
            "4.8 ms of it is the maker's low-pass; whether the rest lies in the encoder's reading "
            "or in the bus is not told"
        ),
        lambda answer: _judged_delay(answer, by_angle),
    )


def _gravity_delay(recordings: Recordings) -> Fact:
    recording = recordings[SHAFT]
    late = delay_by_gravity(recording)
    pattern = delay_by_pattern(recording)

    def declared(answer: Answer) -> Judged:
        both = findings(answer, "accel_axis_skew", "size_effect")
        return Judged(in_words(both), "wrong") if both else silent(answer)

    return Fact(
        "gravity_delay",
        (SHAFT,),
        "the accelerometers are late, too, but less than the gyro",
        (
            "turn of gravity's pattern with the rate",
            "lag at which gravity's pattern over the angle fits best, no lever arm",
        ),
        (str(late), str(pattern)),
        (
            "the two ways differ by what a lever arm takes, more than their scatter; no catalogue "
            "name has one delay for each triad: a single τ must be wrong for one of them"
        ),
        declared,
    )


def _low_pass(recordings: Recordings) -> Fact:
    observation = corner(recordings[SHAFT])
    known = 1e3 / (2.0 * np.pi * observation.value)

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "bandwidth")
        value = parameter(response[0], "time_constant") if response else None
        if value is None:
            return silent(answer)
        at = Measured(1.0 / (2.0 * np.pi * value[0]), 2.0, "Hz")
        close = value[0] > 0 and at.agrees(observation)
        return Judged(in_words(response), "right" if close else "right name, value off")

    return Fact(
        "low_pass",
        (SHAFT,),
        f"the gyro's low-pass, time constant {known:.1f} ms",
        (
            "gain at the stepper's 12.8 Hz beside the gain at 1 to 5 Hz",
            "the maker's setting",
        ),
        (str(observation), str(DATASHEET)),
        "its order: one frequency shows one number",
        declared,
    )


def _rounding(recordings: Recordings) -> Fact:
    recording = recordings[SHAFT]
    steps = {name: step_of(recording.imu.columns[name]) for name in ACCEL}
    (nearest, zero) = (dead_zone_misfit(recording, towards_zero=way) for way in (False, True))

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "coarse_quantisation")
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "rounding",
        (SHAFT,),
        "accelerometers in steps of 0.01 g, cut off towards zero",
        (
            "every reading is a whole number of steps",
            "accelerometer y over the angle: misfit if rounded, and if cut off",
        ),
        (
            f"{steps['accel_y']:.5f} m/s²",
            f"{1e3 * nearest:.1f} and {1e3 * zero:.1f} mm/s²",
        ),
        "where it was cut: in the logger's text or before",
        declared,
    )


# Two VN-200 that rode the same rate table at the same time.

FIRST, SECOND = "vn200_imu0_rate_table", "vn200_imu1_rate_table"
BENCH = "vn200_57630_six_position"
MOST_PER_TURN = 48.0


def on_rate_table(recordings: Recordings) -> list[Fact]:
    """What the table did to both, what became of their files, and labels that are upside down."""
    return [_ripple(recordings), _exchanged(recordings), _reversed(recordings)]


def _ripple(recordings: Recordings) -> Fact:
    one, other = recordings[FIRST], recordings[SECOND]
    depths = [
        f"{waves_per_turn(each)} a turn; {ripple(each, MOST_PER_TURN, 30.0)}"
        for each in (one, other)
    ]
    alike = together(one, other, MOST_PER_TURN)

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "rate_ripple")
        if response:
            return Judged(in_words(response), "right")
        located = [
            each
            for each in findings(answer, "unnamed")
            if any(p["name"] in ("per_turn", "order", "frequency") for p in each["parameters"])
            and any(channel.startswith("gyro") for channel in each["channels"])
        ]
        return Judged(in_words(located), "right") if located else silent(answer)

    return Fact(
        "ripple",
        (FIRST, SECOND),
        "the table's rate ripples 48 (and 44) times a turn",
        (
            "strongest line of the turning gyro of IMU0, x and y turns at 30 deg/s",
            f"the same in IMU1, which rode with it: coherence {alike:.3f}",
        ),
        (depths[0], depths[1]),
        (
            "motor cogging, or its drive: not told; turns about z have it not, which speaks for "
            "another set-up of the drive"
        ),
        declared,
    )


def _exchanged(recordings: Recordings) -> Fact:
    directions, mine = means_of(recordings[FIRST])
    _, theirs = means_of(recordings[SECOND])
    mine, theirs = mine[:, 3:], theirs[:, 3:]
    before = [_size(misfit(directions, each)) for each in (mine, theirs)]
    after = {}
    for axis, name in enumerate("xyz"):
        turned = np.abs(directions[:, axis]) > 0
        pair = (np.where(turned[:, None], theirs, mine), np.where(turned[:, None], mine, theirs))
        after[name] = [_size(misfit(directions, each)) for each in pair]

    def declared(answer: Answer) -> Judged:
        response = findings(answer, "unnamed", channel="accel_z")
        wrong = [
            each
            for each in answer.get("findings", ())
            if each["effect"] != "unnamed" and "accel_z" in each["channels"]
        ]
        if wrong:
            return Judged(in_words(wrong), "wrong")
        return Judged(in_words(response), "right") if response else silent(answer)

    return Fact(
        "exchanged",
        (FIRST, SECOND),
        "z rests of the two units were exchanged",
        (
            "misfit of the accelerometers' six rests to bias and matrix, IMU0 and IMU1",
            "the same with the z rests exchanged; in brackets with x, with y",
        ),
        (
            _pair(before),
            f"{_pair(after['z'])} ({_pair(after['x'])}; {_pair(after['y'])})",
        ),
        "when and by whom; one recording alone cannot tell: `unnamed` is right",
        declared,
    )


def _reversed(recordings: Recordings) -> Fact:
    directions, means = means_of(recordings[BENCH])
    along = (directions * means[:, 3:]).sum(axis=1)

    def declared(answer: Answer) -> Judged:
        return silent(answer)

    return Fact(
        "reversed",
        (BENCH,),
        "labels of x and y are upside down",
        (
            "reading along the label: x, x, y, y",
            "the same for z, z",
        ),
        (
            ", ".join(f"{value:.2f}" for value in along[:4]) + " m/s²",
            ", ".join(f"{value:.2f}" for value in along[4:]) + " m/s²",
        ),
        "whether the labels or a unit turned half round about z: the same data",
        declared,
    )


def _size(left: np.ndarray) -> float:
    """Root mean square, mm/s², of the largest channel; two degrees of freedom."""
    return float(1e3 * np.sqrt((left**2).sum(axis=0) / 2.0).max())


def _pair(sizes: list[float]) -> str:
    return " and ".join(f"{size:.1f}" for size in sizes) + " mm/s²"


# Claims of explain on real recordings that look doubtful, tried by hand.

BY_HAND = "ferraris_session"
VISIBLE = 3.3  # amplitude over its surroundings that noise shows once in 2000 places
FAINT = 2.0  # and once in 16
MOVED = 1.0  # m/s²: a unit that is being handled


def claims_of(recordings: Recordings) -> list[Claim]:
    """Every doubtful claim with its trial."""
    return [
        _line(recordings, RING_LASER, 9.184, (1,), parts=3),
        _line(recordings, MEMS, 36.702, (3, 5)),
        _line(recordings, MEMS, 35.754, (3, 5)),
        _line(recordings, BENCH, 14.158, (1,)),
        _line(recordings, BENCH, 3.619, (0,)),
        _walk(recordings, BENCH, (3, 4, 5), "accelerometers", "加速度计"),
        _walk(recordings, BENCH, (0, 2), "gyros x and z", "陀螺x、z"),
        _as_many_as_rests(recordings),
        _walk(recordings, BY_HAND, (3, 4, 5), "accelerometers", "加速度计"),
        _walk(recordings, BY_HAND, (0, 1, 2), "gyros", "陀螺"),
        _bursts(recordings),
        _products(recordings),
        _stepper(recordings),
        _jump(recordings),
    ]


def _line(
    recordings: Recordings, name: str, at: float, channels: tuple[int, ...], parts: int = 1
) -> Claim:
    """A line "there all the time": how far it stands out of each rest, or each part of one."""
    recording, courses = recordings[name], []
    for rest in rests(recording):
        t, values = readings(recording, rest)
        for rows in np.array_split(np.arange(len(t)), parts):
            least = [prominence(t[rows], values[rows, c], at) for c in channels]
            courses.append(float(np.median(least)))
    there = [series > VISIBLE for series in courses]
    # Weak lines need not show in each rest: together they must (mean square of Rayleigh draws).
    together = float((np.square(courses) * np.log(2.0)).sum())
    chance = float(np.exp(-together) * sum(_powers(together, len(courses))))
    gone = max(courses) > VISIBLE and (min(courses) < FAINT or min(courses) < 0.05 * max(courses))
    truth: Truth = "false" if gone or chance > 0.001 else "true" if any(there) else "cannot tell"
    shown = ", ".join(f"{series:.1f}" for series in courses)
    where = ", ".join(CHANNELS[c] for c in channels)
    return Claim(
        name,
        f"a line at {at:g} Hz, there all the time",
        truth,
        f"amplitude over its surroundings in {where}, rest by rest: {shown} (noise: 1)",
        lambda answer: bool(lines_at(answer, at, 0.02)),
    )


def _powers(x: float, count: int) -> list[float]:
    """Terms of the survival function of a sum of `count` exponential draws: xᵏ/k!."""
    terms = [1.0]
    for k in range(1, count):
        terms.append(terms[-1] * x / k)
    return terms


def _walk(recordings: Recordings, name: str, channels: tuple[int, ...], en: str, zh: str) -> Claim:
    tried = wander(recordings[name], channels)
    truth: Truth = (
        "true"
        if tried.verdict == "true"
        else "false"
        if tried.verdict == "false"
        else "cannot tell"
    )
    return Claim(
        name,
        f"biases of the {en} wander",
        truth,
        (
            "second less first halves of the rests: so much by noise alone p = "
            f"{tried.p_noise:.2g}, so little by a walk that makes the misfit between the rests "
            f"p = {tried.p_walk:.2g}"
        ),
        lambda answer: any(
            CHANNELS[c] in each["channels"]
            for each in findings(answer, "bias_random_walk")
            for c in channels
        ),
    )


def _bursts(recordings: Recordings) -> Claim:
    recording, shown = recordings[SECOND], []
    for rest in rests(recording):
        _, values = readings(recording, rest)
        off = np.abs(values[:, 3:] - np.median(values[:, 3:], axis=0)).max(axis=1)
        shown.append((float(off[:50].max()), float(off[-50:].max())))
    truth: Truth = "true" if sum(max(pair) > MOVED for pair in shown) > 1 else "false"
    words = ", ".join(f"{a:.2f}/{b:.2f}" for a, b in shown)
    return Claim(
        SECOND,
        "four bursts that fade, at 505, 867, 1240 and 1301 s",
        truth,
        (
            f"largest deviation in the first/last second of each rest, m/s²: {words}; only z up "
            "was handled while labelled as a rest"
        ),
        lambda answer: any(
            parameter(each, "decay") is not None for each in findings(answer, "unnamed")
        ),
    )


def _products(recordings: Recordings) -> Claim:
    nearest, zero = (dead_zone_misfit(recordings[SHAFT], towards_zero=way) for way in (False, True))
    truth: Truth = "false" if zero < 0.7 * nearest else "cannot tell"
    return Claim(
        SHAFT,
        "accelerometer y follows products and squares of the other forces",
        truth,
        (
            f"misfit over the angle {1e3 * nearest:.1f} mm/s² if readings are rounded, "
            f"{1e3 * zero:.1f} if they are cut off towards zero: mostly a matter of rounding"
        ),
        lambda answer: any(
            any(word in str(each["follows"]) for word in ("product", "squares"))
            for each in findings(answer, "unnamed", channel="accel_y")
        ),
    )


def _stepper(recordings: Recordings) -> Claim:
    at, coherence = line_shared(recordings[SHAFT])
    return Claim(
        SHAFT,
        f"a line at {at:.2f} Hz beyond the motion",
        "false" if coherence > 0.95 else "cannot tell",
        (
            f"the encoder sees it, too: coherence with the gyro {coherence:.4f}; it is motion, "
            "which a smoothed encoder rate damps"
        ),
        lambda answer: bool(lines_at(answer, at, 0.1)),
    )


def _jump(recordings: Recordings) -> Claim:
    when, until = 33.14, 34.86
    jump = jump_at(recordings[SHAFT], "gyro_z", when)
    brief = excursion(recordings[SHAFT], "gyro_z", when, until)
    value, u, off, scatter = np.degrees([jump.value, jump.u, brief.value, brief.u])
    return Claim(
        SHAFT,
        f"gyro z jumps at {when:.1f} s",
        "true" if abs(value) > 4.0 * u else "false",
        (
            f"mean of the strokes after less before: {value:.3f} ± {u:.3f} deg/s; between "
            f"{when:.1f} and {until:.1f} s it is off by {off:.2f} ± {scatter:.2f} deg/s of the "
            "same place in other strokes: brief, no bias"
        ),
        lambda answer: any(
            "jumps" in str(each["follows"]) or each["effect"] == "bias_step"
            for each in findings(answer, "bias_step", "unnamed", channel="gyro_z")
        ),
    )


def _as_many_as_rests(recordings: Recordings) -> Claim:
    """Six rests cannot try a model of six parameters a gyro."""
    directions, means = means_of(recordings[BENCH])
    pairs = [np.degrees(means[np.abs(directions[:, a]) > 0, 0].mean()) for a in range(3)]
    shown = ", ".join(f"{value:.4f}" for value in pairs)
    return Claim(
        BENCH,
        "biases of the gyros follow acceleration squared",
        "cannot tell",
        (
            f"gyro x, mean of each pair of rests in the order of time: {shown} deg/s. Bias, "
            "g- and g²-sensitivity are six parameters and fit any six rests; a slow drift fits too"
        ),
        lambda answer: bool(findings(answer, "gyro_g2_sensitivity")),
    )


# Effects that are really present in the real recordings, and doubtful claims, all by hand.

RECORDINGS = (
    "ln100_two_position", "adi_mems_two_position", "encoder_mpu6050_pitch_slow",
    "ferraris_session", "vn200_57630_six_position", "vn200_imu0_rate_table",
    "vn200_imu1_rate_table",
)  # fmt: skip
# xsens_multiposition tells no motion: explain refuses it, rightly.


def facts_of(recordings: Recordings) -> list[Fact]:
    """Everything known of the recordings, by hand alone."""
    return [*two_positions(recordings), *on_shaft(recordings), *on_rate_table(recordings)]


def doubtful(recordings: Recordings) -> list[Claim]:
    """Claims that explain makes, or made, and what the hand says of them."""
    return claims_of(recordings)
