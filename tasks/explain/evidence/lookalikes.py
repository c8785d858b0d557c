"""Refusals that one kind of physics alone asks for: what looks like it, and is something else.

A dead band takes nothing off at rest; what it seems to take off there is what errs in the rate that
the reference tells of a rest. Of faster rates it takes its whole threshold off.

A bias that jumps is the same before and the same after. What the first few cells of a recording, or
the last, have of their own is no jump for that: a warm-up, or a rest that is unlike all the motion
after it, sets them apart as well, and too few cells do not tell that their bias is one.

Any loop of a memory is a sum of plays (Prandtl and Ishlinskii), whose weights are of one sign, for
each takes energy. Weights of both signs are a curvature or a derivative of the drive, no memory.

Where neither encoders nor poses tell the attitude, each rest is as it was placed, and that is off
by what it is. A law of the attitude with as many parameters as the rests leave values beside the
standard's would make up for any errors of placing.

Well below its corner a low-pass that lags by T changes its input f by −T·ḟ + b·f̈ with b between
T²/2 (a delay) and T² (one pole), and the model has that. A mount that swings lags by its damping,
and is off by the square of its period: by −f̈/ω₀² below its resonance, and by all of f above.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from tasks.explain.channels import ACCELS
from tasks.explain.evidence.cells import scatter_cells
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.groups import FindingGroup, fitted_columns
from tasks.explain.explanation import Refusal, RefusalKind
from tasks.explain.odds import COVERAGE
from tasks.explain.whitening import equations_of
from tasks.model.regression import inverse
from tasks.model.term import Inputs, Parameter, parameters_of
from tasks.model.terms.electronics import BANDWIDTH
from tasks.model.terms.gyro import THRESHOLD
from tasks.motion.whole import Motion

KNOWN_SIZE = 0.3  # by which physics that is known beforehand may differ from what is known
SIZE = Parameter("size", "size", "1", "1", (1.0 - KNOWN_SIZE, 1.0 + KNOWN_SIZE))
UNSEEN = 1e-3  # p value of coefficients that the faster rates show
FAST_THRESHOLDS = 3.0  # thresholds: faster than what the errors of a rest make of it
FEWEST_CELLS = 3  # cells on either side: two tell a change by themselves
MEMORY = "hysteresis"
STANDARD_AT_REST = 12  # accelerometers' matrix and bias
RESTING = np.radians(0.1)  # rad/s
OF_ACCELEROMETERS = ("accel_time_constant", "accel_lag")
CLEAR_LAG = 3.0  # standard uncertainties
MORE_CURVED = 2.0  # times the square of the lag: more than any order of filter differs by


@dataclass(frozen=True)
class Examined:
    """A finding by its number in some evidence, with the values and the standard uncertainties
    (k,) of its own columns.
    """

    evidence: Evidence
    number: int
    values: np.ndarray
    u: np.ndarray

    @property
    def group(self) -> FindingGroup:
        return self.evidence.groups[self.number]

    @cached_property
    def parameters(self) -> list[Parameter]:
        """Of each own column; known physics has a size, which is one."""
        return [parameter or SIZE for parameter in self.evidence.parameters(self.number)]

    def refused(self, kind: RefusalKind, k: int, value: float, limit: float) -> Refusal:
        """For the value of its parameter k."""
        parameter = self.parameters[k]
        name, unit = parameter.name, parameter.si
        return Refusal(kind, self.group.name, name, unit, value, limit)


def unseen_turning(one: Examined) -> Refusal | None:
    """Where a dead band's coefficients may be nothing by the faster rates alone."""
    evidence, fit, group = one.evidence, one.evidence.fit, one.group
    bands = [term for term in group.terms if THRESHOLD in term.shapes]
    if not bands:
        return None
    threshold = max(band.at[band.shapes.index(THRESHOLD)] for band in bands)
    blocks, model = fit.blocks, fit.model
    columns, prediction = fitted_columns(model, evidence.groups, blocks.motion)
    misfit = blocks.readings - prediction
    reported = np.nan_to_num(blocks.motion.rate)
    felt = reported + np.nan_to_num(misfit[:, :3])  # of a rest whose reference errs: nothing
    fast = np.minimum(np.abs(reported), np.abs(felt)) > FAST_THRESHOLDS * threshold
    turning = replace(blocks, weight=blocks.weight * np.hstack([fast, np.ones_like(fast)]))
    normal, right, _ = equations_of(columns, misfit, turning, fit.noises).normal()
    right = right + normal @ evidence.scatter.values
    covariance = inverse(normal + np.diag(evidence.prior))
    free = np.flatnonzero(model.free)
    places = [p for band in bands for p in range(*model.places[band.key].indices(len(model.free)))]
    own = np.flatnonzero(np.isin(free, places))
    values = (covariance @ right)[own]
    covariance = covariance[np.ix_(own, own)] * evidence.scatter.dispersion(one.number)
    if chi2.sf(values @ inverse(covariance) @ values, len(own)) < UNSEEN:
        return None
    u = np.sqrt(np.diag(covariance))
    k = int((np.abs(values) / u).argmax())
    parameter = parameters_of(model.terms)[free[own[k]]]
    return Refusal(
        "undetermined", group.name, parameter.name, parameter.si,
        float(values[k]), COVERAGE * float(u[k]),
    )  # fmt: skip


def jump_at_one_end(one: Examined) -> Refusal | None:
    """The jump that has too few cells before or after it to show that the bias is constant
    there.
    """
    group, blocks = one.group, one.evidence.fit.blocks
    times = [term.at[0] for term in group.terms if term.time_course == "jump"]
    if not times:
        return None
    cells, used = scatter_cells(blocks), (blocks.weight > 0).any(axis=1)
    before, after = (
        len(np.unique(cells[used & side]))
        for side in (blocks.t < min(times), blocks.t > max(times))
    )
    if min(before, after) >= FEWEST_CELLS:
        return None
    return Refusal("one_end", group.name, value=float(min(before, after)))


def loops_both_ways(one: Examined) -> Refusal | None:
    """A memory whose widths have weights of both signs, each larger than its U, in one channel."""
    if one.group.name != MEMORY:
        return None
    clear = np.where(np.abs(one.values) > COVERAGE * one.u, np.sign(one.values), 0.0)
    signs: dict[tuple[str, str], set[float]] = {}
    for parameter, sign in zip(one.parameters, clear.tolist(), strict=True):
        channel = parameter.unit, parameter.name.rsplit("_", 1)[-1]
        signs.setdefault(channel, set()).add(sign)
    both = any({1.0, -1.0} <= found for found in signs.values())
    return Refusal("both_ways", MEMORY) if both else None


def made_by_placing(one: Examined) -> Refusal | None:
    """Where a finding that turns the body has no fewer parameters than the rests leave values."""
    group, motion = one.group, one.evidence.fit.blocks.motion
    if motion.axes is not None or motion.tracking is not None:
        return None
    if not any(term.stage == "motion" for term in group.terms):
        return None
    placed = _placements(one.evidence)
    if 3 * placed - STANDARD_AT_REST > len(one.evidence.own[one.number][0]):
        return None
    return Refusal("placed", group.name, value=float(placed))


def _placements(evidence: Evidence) -> int:
    """Rests that were each positioned separately."""
    blocks = evidence.fit.blocks
    rests = np.linalg.norm(np.nan_to_num(blocks.motion.rate, nan=np.inf), axis=1) < RESTING
    return len(np.unique(blocks.segment[rests & (blocks.segment >= 0)]))


def swings(one: Examined) -> Refusal | None:
    """A low-pass of the accelerometers alone whose amplitude is not that of a filter."""
    lags = [
        value
        for parameter, value, u in zip(
            one.parameters, one.values.tolist(), one.u.tolist(), strict=True
        )
        if parameter.name in OF_ACCELEROMETERS or abs(value) > CLEAR_LAG * u
    ]
    alone = [parameter.name in OF_ACCELEROMETERS for parameter in one.parameters]
    if one.group.name != BANDWIDTH.name or not any(alone) or len(lags) > sum(alone):
        return None
    curvature, own = _curvature(one.evidence)
    if abs(curvature) < max(CLEAR_LAG * own, MORE_CURVED * max(lags) ** 2):
        return None
    return Refusal("swings", one.group.name)


def _curvature(evidence: Evidence) -> tuple[float, float]:
    """Coefficient c of the second derivative of the specific force in the accelerometers beside
    everything else, and its standard uncertainty; s².
    """
    fit = evidence.fit
    model, blocks = fit.model, fit.blocks
    design = model.linearised(blocks.motion, model.free)
    columns = [design.columns[p] for p in np.flatnonzero(model.free)]
    second = _second_derivative(blocks.motion)
    columns.append({channel: second[:, channel - ACCELS[0]] for channel in ACCELS})
    misfit = blocks.readings - design.prediction
    normal, right, chi2 = equations_of(columns, misfit, blocks, fit.noises).normal()
    covariance = inverse(normal)
    dispersion = max(1.0, chi2 / evidence.used)
    return float((covariance @ right)[-1]), float(np.sqrt(dispersion * covariance[-1, -1]))


def _second_derivative(motion: Motion) -> np.ndarray:
    """(n, 3) of the specific force, m/s⁴; zero where it is not known."""
    force = Inputs.of(motion).force
    slope = np.gradient(force, motion.t, axis=0)
    return np.nan_to_num(np.gradient(slope, motion.t, axis=0))
