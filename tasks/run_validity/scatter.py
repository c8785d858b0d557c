"""Scatter of the unit's readings at rest: vibration, and rests that differ more than they may."""

from collections.abc import Iterator, Mapping

import numpy as np

from schemas.calibration import Item
from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.run_validity.remark import run_remark
from tasks.segments.summarise import CHANNELS
from tasks.specifications.course import comparable
from tasks.specifications.evidence import ClauseEvidence

# Standard deviation of the rows of a rest: noise of no unit that is worth a calibration.
MOST_DEVIATION = np.array([np.radians(1.0)] * len(AXES) + [0.5] * len(AXES))  # rad/s, m/s²
ABOVE_OTHERS = 5.0  # times that of the run's usual rest
STEPS = 2.0  # of the output: what rounding makes of a quiet rest
BEYOND = 3.0  # times U of the zero and what the rest's own noise may do to it
# No unit is calibrated whose zero wanders so far within a run: rad/s, m/s².
LARGEST_DRIFT = (*[float(np.radians(0.1))] * len(AXES), *[0.05] * len(AXES))
ZEROS = (("gyro_bias", 0), ("ahrs_zero_offset", 0), ("accel_bias", 3))  # item, first channel
PER_SI = {"deg/s": float(np.degrees(1.0)), "m/s2": 1.0}


def scatter_remarks(evidence: ClauseEvidence, items: Mapping[str, Item]) -> Iterator[Remark]:
    """Channels whose rests disagree with one another by more than U covers, or a steady unit."""
    yield from _beyond_uncertainty(evidence, items)
    for channel, largest in enumerate(LARGEST_DRIFT):
        rests = comparable(evidence, _rests(evidence, None), channel)
        alike = channel < len(AXES) and "ahrs_zero_offset" in items  # no model of g-sensitivity
        faces = np.ones((len(rests), 1)) if alike else _faces(evidence, rests)
        drift = _drift(evidence, rests, faces, channel, largest)
        if drift is not None:
            segment, left = drift
            yield run_remark(
                "unsteady_zero", segment, run="invalid", channel=CHANNELS[channel],
                segment=segment, left=f"{left:+.2g}", limit=f"{largest:.2g}",
            )  # fmt: skip


def _beyond_uncertainty(evidence: ClauseEvidence, items: Mapping[str, Item]) -> Iterator[Remark]:
    """By the uncertainty that is stated for each zero."""
    for name, first in ZEROS:
        for number, axis in enumerate(AXES if name in items else ()):
            item, U = items[name], items[name].U.get(axis)
            rests = _rests(evidence, axis if name == "ahrs_zero_offset" else None)
            rests = comparable(evidence, rests, first + number)
            per_si = PER_SI[item.unit]
            faces = _faces(evidence, rests)
            drift = U and _drift(evidence, rests, faces, first + number, BEYOND * U / per_si)
            if drift:
                segment, left = drift
                yield run_remark(
                    "drift", segment, run="invalid", channel=CHANNELS[first + number],
                    segment=segment, left=f"{per_si * left:+.2g}", U=f"{U:.2g}", unit=item.unit,
                )  # fmt: skip


def _rests(evidence: ClauseEvidence, axis: Axis | None) -> list[int]:
    """The rests with a known axis up; of an AHRS those in which its zero about an axis is held."""
    rests = [i for i in evidence.of_kind("static") if evidence.up[i] is not None]
    return [i for i in rests if axis is None or evidence.labels[i].axis == axis]


def _drift(
    evidence: ClauseEvidence, rests: list[int], faces: np.ndarray, channel: int, allowed: float
) -> tuple[str, float] | None:
    """The rest that is farthest off, and by how much (SI); None: within `allowed` and its noise.

    Each is compared with a fit of all: a reading for each column of `faces` (rests, k), and the
    level part of Earth's rotation; if north is unknown, that much more is allowed.
    """
    means = evidence.means[rests, channel]
    if len(rests) <= faces.shape[1] or not np.isfinite(means).all():
        return None
    variance = evidence.noise.white[rests, channel] / evidence.noise.seconds[rests]
    variance += evidence.rounding_covariance(channel).diagonal()[rests]
    if evidence.accumulates:  # the two readings of an angle that make a short rest's mean rate
        variance = evidence.fast_covariance(channel).diagonal()[rests]
    noise = 2.0 * np.sqrt(variance)
    if channel < len(AXES):
        north = evidence.north[rests]
        known = bool(np.isfinite(north).all())
        level = _level(north, evidence, rests)[:, channel] if known else ()
        faces = np.column_stack([faces, *level])
        noise = noise + (0.0 if known else EARTH_RATE)
    left = means - faces @ np.linalg.lstsq(faces, means, rcond=None)[0]
    reach = allowed + BEYOND * noise
    worst = int((np.abs(left) / reach).argmax())
    if abs(left[worst]) <= reach[worst]:
        return None
    return evidence.labels[rests[worst]].name, float(left[worst])


def _faces(evidence: ClauseEvidence, rests: list[int]) -> np.ndarray:
    """(rests, faces): 1 where a rest has that axis up."""
    ups = sorted({str(evidence.up[i]) for i in rests})
    return np.array([[evidence.up[i] == up for up in ups] for i in rests], float).reshape(
        len(rests), len(ups)
    )


def _level(north: np.ndarray, evidence: ClauseEvidence, rests: list[int]) -> np.ndarray:
    """North and east (2, 3, rests) in the body."""
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    return np.stack([north.T, np.cross(north, up).T])


def vibration_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rests that scatter more than any unit's noise, or much more than the others."""
    rests = [evidence.segments[i] for i in evidence.of_kind("static")]
    if not rests:
        return
    deviation = np.array([rest.deviation for rest in rests])
    usual = np.median(deviation, axis=0)
    step = np.max([rest.step for rest in rests], axis=0)
    limit = np.minimum(MOST_DEVIATION, np.maximum(ABOVE_OTHERS * usual, STEPS * step))
    above = deviation > limit
    for channel in np.flatnonzero(above.any(axis=0)).tolist():
        shaken = [rests[i].segment.name for i in np.flatnonzero(above[:, channel])]
        yield run_remark(
            "vibration", *shaken, run="invalid", channel=CHANNELS[channel], count=len(shaken),
            first=shaken[0], deviation=f"{deviation[:, channel].max():.3g}",
            limit=f"{limit[channel]:.3g}",
        )  # fmt: skip
