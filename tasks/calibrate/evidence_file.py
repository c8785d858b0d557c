"""The evidence of a result: means, combinations, noise and errors, as one document.

It is made again from the recording when somebody asks for it, and not with every result: the
estimation is exact and takes a second, and a store of results stays as small as it is. Whether it
is the evidence of this very result is checked element by element.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.calibration import (
    Calibration,
    ChannelMeans,
    Combination,
    Elements,
    EvidenceFile,
    EvidenceSource,
    EvidenceValue,
    FurtherLine,
    Item,
)
from schemas.recording import Recording
from schemas.tolerance import Decision, Quantity
from tasks.calibrate.calibrate import ENOUGH_DOF, Evaluation
from tasks.segments.summarise import ACCEL_COLUMNS, CHANNELS
from tasks.specifications.equipment_errors import EquipmentErrors, ErrorSource
from tasks.specifications.estimate import (
    OF_DATA,
    ClauseResult,
    Estimate,
    Estimates,
    ItemEstimate,
    Specification,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.uncertainty.budget import Contribution
from tasks.uncertainty.propagation import TWO_SIGMA
from tasks.words import message, statement
from tasks.words.numbers import USUAL_K

DIGITS = 9  # of effects and covariances: three are asked of U, and drift cancels in differences
ROUNDING = 1e-12  # of the terms of a sum: less is no constant
SAME = 1e-6  # relative, of u: more is another result


def why_none(calibration: Calibration) -> str | None:
    """Why a result has no evidence that can be written down; None where it has."""
    kinds = {item.uncertainty_kind for item in calibration.items.values()} - {"GUM"}
    if kinds:
        return (
            f"the uncertainties of result {calibration.run} are evaluated by {kinds.pop()}, and "
            "the evidence is that of the law of propagation: calibrate without --uncertainty"
        )
    if calibration.terms:
        names = ", ".join(term.name for term in calibration.terms)
        return (
            f"result {calibration.run} was corrected for {names} first, of which the means of the "
            "readings show nothing: calibrate without --terms"
        )
    return None


def evidence_file(
    calibration: Calibration,
    specification: Specification,
    recording: Recording,
    evaluation: Evaluation,
    decision: Decision | None = None,
) -> EvidenceFile:
    """What a result of a recording rests on; decision: what was decided on it.

    calibration: as it is stated, no U below the laboratory's capability. Raises Unusable where it
    has none (`why_none`), and where today's estimation, with these limits of the equipment, gives
    another result.
    """
    if reason := why_none(calibration):
        raise Unusable(f"there is no evidence file: {reason}.")
    evidence = specification.gather(recording)
    result = specification.estimate(evidence, evaluation.equipment)
    return _Writer.of(evidence, result).document(calibration, result, decision)


@dataclass(frozen=True)
class _Writer:
    """What the values of a result use of its evidence.

    used: (6, n) bool, the means that some value takes.
    """

    evidence: ClauseEvidence
    errors: EquipmentErrors
    used: np.ndarray

    @classmethod
    def of(cls, evidence: ClauseEvidence, result: ClauseResult) -> "_Writer":
        used = np.zeros((len(CHANNELS), len(evidence.segments)), bool)
        for item in result.items.values():
            for estimate in (
                *item.elements.values(),
                *(item.without_earth_rotation or {}).values(),
            ):
                if estimate.operator is not None:
                    used |= estimate.operator != 0.0
        return cls(evidence, result.errors or EquipmentErrors((), used.shape[1]), used)

    def document(
        self, calibration: Calibration, result: ClauseResult, decision: Decision | None
    ) -> EvidenceFile:
        return EvidenceFile(
            recording_id=calibration.recording_id,
            run=calibration.run,
            digest=calibration.digest,
            method=calibration.method,
            procedure=calibration.procedure,
            code_version=calibration.code_version,
            segments=tuple(label.name for label in self.evidence.labels),
            channels=tuple(map(self._channel, range(len(CHANNELS)))),
            sources=tuple(map(self._source, self.errors.sources)),
            values=tuple(self._values(calibration, result.items)),
            covariance=calibration.covariance,
            coverage=statement(
                message(
                    "evidence-coverage", k=f"{USUAL_K:g}", probability=f"{100 * TWO_SIGMA:.2f}",
                    dof=f"{ENOUGH_DOF:g}",
                )
            ),
            decision=decision,
        )  # fmt: skip

    def _channel(self, c: int) -> ChannelMeans:
        used = np.flatnonzero(self.used[c])
        covariance = _short(self.evidence.covariance(c)[np.ix_(used, used)])
        return ChannelMeans(
            name=self.evidence.channel_names[c],
            unit="m/s2" if c >= ACCEL_COLUMNS.start else "rad/s",
            segments=tuple(used.tolist()),
            means=tuple(self.evidence.means[used, c].tolist()),
            covariance=tuple(tuple(row[: i + 1].tolist()) for i, row in enumerate(covariance)),
        )

    def _source(self, source: ErrorSource) -> EvidenceSource:
        quantity = source.quantity
        kept = np.where(self.used.T, source.effects, 0.0).swapaxes(1, 2)  # (m, 6, n)
        return EvidenceSource(
            symbol=quantity.symbol,
            name=statement(quantity.name),
            unit=quantity.unit,
            scope=source.scope,
            distribution=quantity.distribution,
            u=quantity.u,
            half_width=quantity.half_width,
            stated_by=quantity.source,
            latitude=source.of_latitude,
            draws=tuple(self._combination(_short(each)) for each in kept if each.any()),
        )

    def _values(
        self, calibration: Calibration, estimated: Mapping[str, ItemEstimate]
    ) -> Iterator[EvidenceValue]:
        """Every value of the result, those beside the clauses' own too."""
        for name, item in calibration.items.items():
            for column in _columns(item, estimated[name]):
                for element, value in column.value.items():
                    u, estimate = column.u.get(element), column.estimates[element]
                    _check_same(calibration, f"{name}.{element}", value, u, estimate)
                    if value is None:
                        continue
                    budget, U = item.budgets.get(element), column.U.get(element)
                    raised = U is not None and u is not None and item.k * u * (1.0 + SAME) < U
                    yield EvidenceValue(
                        item=name, element=element, quantity=column.quantity, unit=item.unit,
                        value=value, u=u, U=U, k=item.k, capability=U if raised else None,
                        dof=budget.dof if budget else math.inf, **self._basis(estimate),
                    )  # fmt: skip

    def _basis(self, estimate: Estimate) -> dict[str, Any]:
        """How a value follows from the means, and what of its budget does not."""
        o, lines = estimate.operator, estimate.lines
        data = [line for line in lines if line.quantity.symbol in OF_DATA]
        dof = min((line.quantity.dof for line in data), default=math.inf)
        if o is None:
            return {"combination": None, "data_dof": dof, "lines": tuple(map(_further, lines))}
        in_sources = {source.quantity.symbol for source in self.errors.sources}
        means = np.where(o.T != 0.0, self.evidence.means, 0.0)
        terms = o * means.T
        constant = estimate.value - float(terms.sum())
        shown = sum(
            float(row[used] @ self.evidence.covariance(c)[np.ix_(used, used)] @ row[used])
            for c, row in enumerate(o)
            if len(used := np.flatnonzero(row))
        )
        stated = float(np.linalg.norm([line.quantity.u * line.sensitivity for line in data]))
        return {
            "combination": self._combination(o),
            "constant": constant if abs(constant) > ROUNDING * np.abs(terms).sum() else 0.0,
            "scatter": stated / math.sqrt(shown) if shown > 0.0 else 1.0,
            "data_dof": dof,
            "without_earth": estimate.without_earth,
            "lines": tuple(
                _further(line)
                for line in lines
                if line not in data and line.quantity.symbol not in in_sources
            ),
        }

    def _combination(self, weights: np.ndarray) -> Combination:
        """Weights (6, n) without their zeros."""
        place = np.cumsum(self.used, axis=1) - 1
        channel, segment = np.nonzero(weights)
        return Combination(
            channel=tuple(channel.tolist()),
            mean=tuple(place[channel, segment].tolist()),
            weight=tuple(weights[channel, segment].tolist()),
        )


@dataclass(frozen=True)
class _Column:
    """One of the values of an item, with the estimates that it was made of."""

    quantity: Quantity
    value: Elements
    u: Elements
    U: Elements
    estimates: Estimates


def _columns(item: Item, found: ItemEstimate) -> Iterator[_Column]:
    """The value by the clause, that of model (2), and that without Earth's rotation."""
    yield _Column("value", item.value, item.u, item.U, found.elements)
    if item.value_model is not None:
        opposite = {e: estimate.scaled(-1.0) for e, estimate in found.elements.items()}
        yield _Column("value_model", item.value_model, item.u, item.U, opposite)
    if item.value_without_earth_rotation is not None:
        yield _Column(
            "value_without_earth_rotation", item.value_without_earth_rotation,
            item.u_without_earth_rotation or {}, item.U_without_earth_rotation or {},
            found.without_earth_rotation or {},
        )  # fmt: skip


def _further(line: Contribution) -> FurtherLine:
    quantity = line.quantity
    contribution = quantity.u * abs(line.sensitivity)
    return FurtherLine(
        symbol=quantity.symbol, name=statement(quantity.name), contribution=contribution
    )


def _short(numbers: np.ndarray) -> np.ndarray:
    """Numbers to DIGITS significant digits."""
    size = np.abs(numbers, where=numbers != 0.0, out=np.ones_like(numbers))
    step = 10.0 ** (DIGITS - 1 - np.floor(np.log10(size)))
    return np.round(numbers * step) / step


def _check_same(
    calibration: Calibration, name: str, value: float | None, u: float | None, estimate: Estimate
) -> None:
    """Raises Unusable where an element is not what it was when the result was made."""
    made = estimate.value if estimate.determined else None
    reach = ROUNDING * abs(value or 0.0) + SAME * (u or 0.0)
    same = made is None if value is None else made is not None and abs(made - value) <= reach
    if u is not None:
        lines = [line.quantity.u * line.sensitivity for line in estimate.lines]
        same = same and abs(float(np.linalg.norm(lines)) - u) <= SAME * u
    if not same:
        raise Unusable(
            f"there is no evidence file: {name} of run {calibration.run} is {value!r} in this "
            f"result (u = {u!r}) and {made!r} by today's program and limits of the equipment: "
            "calibrate the run again."
        )
