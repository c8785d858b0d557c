"""The errors of the equipment of a run, for a unit as a clause found it."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from schemas.recording import AXES, Axis, Recording
from schemas.text import Remark
from tasks.model.term import Term, nominal_values
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.table import labelled_direction, mean_rate
from tasks.motion.whole import (
    Motion,
    attitude_stream,
    gravity_of,
    unit_vector,
    whole_motion,
)
from tasks.segments.rates import held_rate
from tasks.specifications.equipment_errors import EquipmentErrors, equipment_errors
from tasks.specifications.estimate import Estimates, MeansFit, fit_means
from tasks.specifications.evidence import ClauseEvidence, solve
from tasks.uncertainty.equipment import Equipment
from tasks.words import message, remark

UNKNOWN_LATITUDE_DEG = 45.0  # where it is only asked what tilts do to Earth's rotation


def errors_of_unit(
    evidence: ClauseEvidence,
    motion: Motion,
    equipment: Equipment,
    found: Mapping[str, Estimates] | None = None,
) -> EquipmentErrors:
    """The errors for models (1) and (2) of a unit.

    found: its estimates by term, in SI units; an ideal unit where they are not determined.
    """
    latitude_deg = evidence.latitude_deg
    phi = np.radians(UNKNOWN_LATITUDE_DEG if latitude_deg is None else latitude_deg)

    def terms_at(off: float) -> tuple[Term, ...]:
        return (earth_rotation(float(phi) + off), *STANDARD_TERMS)

    return equipment_errors(evidence, motion, terms_at, _values(found or {}), equipment)


def _values(found: Mapping[str, Estimates]) -> np.ndarray:
    """(p,) of the standard's terms."""
    values = nominal_values(STANDARD_TERMS)
    names = [
        (term.name, parameter.name) for term in STANDARD_TERMS for parameter in term.parameters
    ]
    for p, (term, element) in enumerate(names):
        estimate = found.get(term, {}).get(element)
        if estimate is not None and estimate.determined:
            values[p] = estimate.value
    return values


def doubled(elements: Estimates) -> Estimates:
    """The elements x, y, z of a matrix's diagonal as xx, yy, zz."""
    return {e * 2 if e in AXES else e: estimate for e, estimate in elements.items()}


# The rate points about an axis, as both specifications use them: a line, 7 to 11 points.

SQUARE = 1e-6  # rad, a fifth of an arc second: so crooked is no mount that anybody states
FEWEST_RATES, MOST_RATES = 7, 11


def distinct_rates(rates: np.ndarray) -> list[float]:
    """The different rates (deg/s, to a tenth) among (n,) rad/s, rising."""
    return sorted(set(np.round(np.degrees(rates), 1).tolist()))


def rate_remarks(axis: str, rates: np.ndarray, clause: str) -> Iterator[Remark]:
    """Where there are fewer or more rates (rad/s) than the clause asks for, or one direction."""
    distinct = distinct_rates(rates)
    if not FEWEST_RATES <= len(distinct) <= MOST_RATES:
        text = message(
            "specifications-number-of-rates", axis=axis, count=len(distinct),
            rates=", ".join(f"{rate:+g}" for rate in distinct), clause=clause, fewest=FEWEST_RATES,
            most=MOST_RATES,
        )  # fmt: skip
        yield remark("number_of_rates", text, blocks_pass=True)
    if distinct[0] >= 0 or distinct[-1] <= 0:
        text = message("specifications-one-direction", axis=axis)
        yield remark("one_direction", text, blocks_pass=True)


def fit_line(
    evidence: ClauseEvidence,
    channel: int,
    points: Sequence[int],
    errors: EquipmentErrors,
    rests: Sequence[int] = (),
) -> MeansFit:
    """Slope and offset over the rate points, eq. (5) of JJF 2003 and eq. (14) of JJF 1536.

    rests: whose mean is subtracted from the output of each point.
    """
    rates = evidence.rate[list(points)]
    outputs = np.eye(len(evidence.segments))[list(points)]
    outputs[:, list(rests)] = -1.0 / max(1, len(rests))
    design = np.column_stack([rates, np.ones(len(rates))])
    return fit_means(evidence, channel, design, outputs, errors)


def weights_about(
    evidence: ClauseEvidence,
    axis: Axis,
    rate: np.ndarray,
    runs: Mapping[Axis, Sequence[int]],
    readings: Mapping[Axis, np.ndarray],
) -> np.ndarray | None:
    """Weights (n,) of what a gyro reads per rate about an axis of the unit.

    rate: (n, 3) rad/s of each segment in the unit's axes. runs, readings: which segments turned,
    and the weights of what it read per rate in them, by the axis that was laid along the table's.
    Turned about a it reads K·a: a row of K follows from all directions. None: the unit stood too
    crooked for those.
    """
    if axis not in readings:
        return None
    design = np.array([direction(evidence, laid, rate, runs[laid]) for laid in readings])
    solution, place = solve(np.where(np.abs(design) < SQUARE, 0.0, design)), AXES.index(axis)
    if not solution.estimable[place]:
        return None
    return np.asarray(solution.operator[place].round(12) @ np.array([*readings.values()]))


def direction(
    evidence: ClauseEvidence, laid: Axis, rate: np.ndarray, turns: Sequence[int]
) -> np.ndarray:
    """Mean direction (3,) in the unit's axes of turns about the table's, per rate about it.

    Where nobody knows it, that of the axis that was laid along it.
    """
    turned, held = rate[list(turns)], np.abs(evidence.rate[list(turns)])
    size = np.where(np.isfinite(held), held, np.linalg.norm(turned, axis=1))
    signed = np.copysign(size, turned[:, AXES.index(laid)])
    known = np.isfinite(turned).all(axis=1) & (signed != 0.0)
    if not known.any():
        return np.eye(3)[AXES.index(laid)]
    return np.asarray((turned[known] / signed[known, None]).mean(axis=0))


# What the unit went through in each segment, on average.

SAMPLES = 400  # times within a segment at which its attitude is looked up
SAME_VERTICAL = np.cos(np.radians(10.0))  # encoders and gravity agree on the axis up within this


def mean_motion(evidence: ClauseEvidence) -> tuple[Motion, np.ndarray]:
    """Mean motion of each segment, and (n,) bool where the vertical in it is known.

    Rests and rates that labels and witnesses contradict are taken as `gather` took them: the axis
    up by gravity, the rate by the encoders. A turn about the vertical has no mean north.
    """
    recording, segments = evidence.recording, evidence.segments
    looked = [np.linspace(s.t_start, s.t_end, SAMPLES, endpoint=False) for s in segments]
    whole = whole_motion(recording, np.concatenate([np.zeros(0), *looked]))
    shape = (len(segments), SAMPLES, 3)
    up, north = whole.up.reshape(shape).mean(axis=1), whole.north.reshape(shape).mean(axis=1)
    rate = mean_rates(evidence)
    rate = np.where(_turned(evidence), rate, 0.0 * rate)
    vertical, stream = np.zeros(len(segments), bool), attitude_stream(recording)
    for i, segment in enumerate(segments):
        shown = labelled_direction(recording.manifest, segment.segment, unit_vector(evidence.up[i]))
        agrees = not np.isfinite(shown).all() or up[i] @ shown >= SAME_VERTICAL
        if stream is None or not np.isfinite(up[i]).all() or not agrees:
            up[i], north[i] = shown, np.nan
        vertical[i] = np.isfinite(up[i]).all()
        if segment.segment.kind != "static":
            north[i] = np.nan_to_num(north[i])
            if not vertical[i] and segment.has_accel:
                up[i] = segment.mean[3:] / gravity_of(recording)
    t = np.array([0.5 * (segment.t_start + segment.t_end) for segment in segments])
    return Motion(t, up, north, rate, np.zeros_like(rate), gravity_of(recording)), vertical


def mean_rates(evidence: ClauseEvidence) -> np.ndarray:
    """Mean rate (n, 3) rad/s of each segment about the unit's axes; NaN where nobody knows it."""
    rates = [_rate(evidence.recording, evidence, i) for i in range(len(evidence.segments))]
    return np.array(rates).reshape(-1, 3)


def _turned(evidence: ClauseEvidence) -> np.ndarray:
    """(3,) bool: axes with a run of rates or a turn; the rest about the others is misalignment.

    Ten microradians of it would otherwise count as an input, and the axis as one that was turned.
    """
    return np.array([bool(evidence.points[axis] or evidence.turns[axis]) for axis in AXES])


def _rate(recording: Recording, evidence: ClauseEvidence, i: int) -> np.ndarray:
    """Mean body rate (3,) rad/s of a segment; NaN where nobody knows it."""
    label = evidence.segments[i].segment
    if label.kind == "static":
        return np.zeros(3)
    if label.kind == "rate" and not np.isfinite(evidence.rate[i]):
        return np.full(3, np.nan)
    shown = held_rate if label.kind == "rate" else mean_rate
    by_table = shown(recording, label)
    if by_table is not None:
        return by_table
    about = np.eye(3)[AXES.index(label.axis or "x")]
    about = labelled_direction(recording.manifest, label, about)
    if label.kind == "rate":
        return np.asarray(evidence.rate[i] * about)
    angle = np.radians(np.nan if label.angle_deg is None else label.angle_deg)
    return about * angle / evidence.segments[i].seconds
