"""Calibrates readings corrected for known physics, with the uncertainty of the corrections."""

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from schemas.calibration import (
    AdoptedTerm,
    Budget,
    BudgetInput,
    Calibration,
    Correlation,
    Elements,
    Item,
)
from schemas.discrepancy import FoundParameter
from schemas.recording import Recording, Stream
from schemas.text import Remark, no_text, text_fields
from tasks.calibrate.calibrate import common_factor, expanded
from tasks.calibrate.information.entry import WITHOUT_EARTH
from tasks.explain.events.detect import RANGE_SETTING
from tasks.explain.explanation import CHANNELS, UNNAMED, DeterminedModel, Finding
from tasks.model.term import Column, effect_name
from tasks.model.terms.memory import BIAS_RANDOM_WALK
from tasks.uncertainty.budget import half_width
from tasks.uncertainty.propagation import coverage_factor, variance_terms
from tasks.words import Message, clauses, message, remark, statement
from tasks.words.numbers import USUAL_K, quantity

# Uncertainty of the findings' contribution to the readings, by each corrected parameter.

MANY = 12  # parameters of a finding, from which on the clauses are not asked for each of them
NEGLIGIBLE = 1e-5  # of the square of what they all move
ROUNDING = 1e-12  # of the largest variance


@dataclass(frozen=True)
class UncertainInput:
    """A parameter of a finding, or a direction of several of them.

    step: (q,) of the determined model's covariance, by one standard uncertainty; form: (q,) what
    of the parameters it is, of unit variance. Neither where `whole`: (n, 6) is the change of the
    readings of a finding that no term makes.
    """

    finding: Finding
    parameter: FoundParameter
    step: np.ndarray | None = None
    form: np.ndarray | None = None
    whole: np.ndarray | None = None

    def change(self, determined: DeterminedModel | None) -> np.ndarray:
        """(n, 6) by which the readings grow with it, by its standard uncertainty."""
        if self.whole is not None:
            return self.whole
        assert determined is not None
        assert self.step is not None
        return determined.change(self.step)


def uncertain_inputs(
    findings: Sequence[Finding], determined: DeterminedModel | None, segments: Sequence[slice] = ()
) -> list[UncertainInput]:
    """What of some findings is uncertain: the fitted parameters of those that terms make; of many
    parameters the directions in which they move the means of the segments (rows of them).

    Physics that is known beforehand has none: its parameters are a check, and were not used. What
    no term makes is as uncertain as its parameters are as a whole. Whether what has no name is to
    be corrected for at all is not known, however well its pattern is.
    """
    every = list[UncertainInput]()
    for finding in findings:
        if finding.effect == UNNAMED and not finding.remainder:
            every.append(_of_unknown_cause(finding))
        if determined is None or not finding.terms:
            every += _as_a_whole(finding)
            continue
        placed = [
            (one, one.place)
            for one in determined.parameters(finding.terms)
            if one.place is not None and one.u > 0.0
        ]
        if len(placed) > MANY and segments:
            places = np.array([place for _, place in placed])
            every += principal_directions(finding, determined, places, segments)
            continue
        for one, place in placed:
            unit = np.eye(1, len(determined.u), place)[0]
            every.append(UncertainInput(finding, one.found, one.u * unit, unit / one.u))
    return every


def principal_directions(
    finding: Finding, determined: DeterminedModel, places: np.ndarray, segments: Sequence[slice]
) -> Iterator[UncertainInput]:
    """Independent combinations of a finding's parameters, by how far they move the readings' means
    over the segments; what moves them next to nothing is left out.

    places: (k,) rows of the covariance, shapes left out. segments: rows of the readings.
    """
    places = places[places < int(determined.model.free.sum())]
    covariance = determined.covariance[np.ix_(places, places)]
    values, vectors = np.linalg.eigh(covariance)
    known = values > ROUNDING * values.max()
    root = vectors[:, known] * np.sqrt(values[known])
    means = _segment_means(determined.columns(places), determined.axes, segments)
    moved = np.tensordot(root.T, means, 1)
    moved /= np.maximum(np.linalg.norm(moved, axis=(0, 1), keepdims=True), 1e-300)
    left, sizes, _ = np.linalg.svd(moved.reshape(len(moved), -1), full_matrices=False)
    kept = sizes**2 > NEGLIGIBLE * float((sizes**2).sum())
    inverse_root = vectors[:, known] / np.sqrt(values[known])
    for number, direction in enumerate(left.T[kept], start=1):
        step, form = np.zeros(len(determined.u)), np.zeros(len(determined.u))
        step[places], form[places] = root @ direction, inverse_root @ direction
        named = FoundParameter(name=f"direction {number}", value=0.0, unit="1", u=1.0)
        yield UncertainInput(finding, named, step, form)


def _segment_means(
    columns: Sequence[Column], axes: np.ndarray, segments: Sequence[slice]
) -> np.ndarray:
    """(k, segments·3, 2) means of columns over each segment, by triad."""
    means = np.zeros((len(columns), len(segments), len(axes)))
    for k, column in enumerate(columns):
        for channel, values in column.items():
            filled = np.nan_to_num(values)
            means[k, :, channel] = [filled[rows].mean() for rows in segments]
    by_triad = (means @ axes.T).reshape(len(columns), len(segments), 2, 3)
    return by_triad.transpose(0, 1, 3, 2).reshape(len(columns), -1, 2)


def correlation_of(
    inputs: Sequence[UncertainInput], determined: DeterminedModel | None
) -> np.ndarray:
    """(m, m) of some inputs; what no term makes goes with nothing."""
    correlation = np.eye(len(inputs))
    formed = [(n, one.form) for n, one in enumerate(inputs) if one.form is not None]
    if determined is not None and formed:
        rows, forms = np.array([n for n, _ in formed]), np.array([form for _, form in formed])
        own = forms @ determined.covariance @ forms.T
        np.fill_diagonal(own, 1.0)
        correlation[np.ix_(rows, rows)] = own
    return correlation


def _of_unknown_cause(finding: Finding) -> UncertainInput:
    """Half of its contribution: ± U (k = 2) about the corrected value reaches the uncorrected."""
    share = FoundParameter(name="share", value=1.0, unit="1", u=0.5)
    return UncertainInput(finding, share, whole=0.5 * np.nan_to_num(finding.contribution))


def _as_a_whole(finding: Finding) -> Iterator[UncertainInput]:
    """The contribution times the largest relative uncertainty of parameters of one unit.

    A factor changes what it multiplies, not what it adds: its relative uncertainty is that of the
    whole reading y, of which (c − 1)/c·y is the contribution.
    """
    if finding.effect == RANGE_SETTING:
        (factor,) = finding.parameters
        share = factor.u / (factor.value * (factor.value - 1.0))
        yield UncertainInput(finding, factor, whole=share * finding.contribution)
        return
    by_unit: dict[str, list[FoundParameter]] = {}
    for p in finding.parameters:
        if p.u > 0.0:
            by_unit.setdefault(p.unit, []).append(p)
    relative = [
        (math.hypot(*(p.u for p in some)) / max(math.hypot(*(p.value for p in some)), 1e-300), some)
        for some in by_unit.values()
    ]
    if relative:
        share, some = max(relative, key=lambda pair: pair[0])
        largest = max(some, key=lambda p: abs(p.value))
        whole = largest.model_copy(update={"u": share * abs(largest.value)})
        yield UncertainInput(finding, whole, whole=share * finding.contribution)


# Adds lines to uncertainty budgets for corrections that are themselves uncertain.


@dataclass(frozen=True)
class CorrectionLines:
    """The budget lines of the corrections: inputs with their correlation (m, m).

    changes: for each input, the change of each element for its standard uncertainty.
    """

    inputs: Sequence[UncertainInput]
    correlation: np.ndarray
    changes: Sequence[Elements]

    @classmethod
    def of(
        cls, inputs: Sequence[UncertainInput], correlation: np.ndarray,
        item: Item, moved: Sequence[Item],
    ) -> "CorrectionLines":  # fmt: skip
        """moved: the item with each parameter greater by its standard uncertainty."""
        return cls(inputs, correlation, [_change(item, other) for other in moved])

    def at(self, element: str) -> np.ndarray:
        """(m,) changes of one element."""
        return np.array([change.get(element) or 0.0 for change in self.changes])

    def u(self, element: str) -> float:
        """The contribution of the corrections to the standard uncertainty of an element, in
        quadrature.
        """
        return math.sqrt(max(float(variance_terms(self.at(element), self.correlation).sum()), 0.0))

    @property
    def symbols(self) -> list[str]:
        """One for each input; those of one name are numbered."""
        seen, symbols = Counter[str](), []
        for one in self.inputs:
            symbol = f"{one.finding.effect}.{one.parameter.name}"
            seen[symbol] += 1
            symbols.append(symbol if seen[symbol] == 1 else f"{symbol}.{seen[symbol]}")
        return symbols

    def budget_inputs(self, element: str, u_c: float) -> tuple[BudgetInput, ...]:
        """The lines in the budget of one element, whose combined uncertainty is u_c."""
        changes = self.at(element)
        shares = variance_terms(changes, self.correlation) / u_c**2
        every = zip(self.inputs, self.symbols, changes.tolist(), shares.tolist(), strict=True)
        return tuple(_line(one, symbol, change, share) for one, symbol, change, share in every)

    def correlations(self, element: str) -> tuple[Correlation, ...]:
        """Of the inputs that change an element."""
        changes, symbols = self.at(element), self.symbols
        both = np.triu(self.correlation, 1) * (changes[:, None] * changes != 0.0)
        return tuple(
            Correlation(first=symbols[i], second=symbols[j], r=float(np.clip(both[i, j], -1, 1)))
            for i, j in zip(*np.nonzero(both), strict=True)
        )


def with_lines(item: Item, lines: CorrectionLines) -> Item:
    """An item with further lines in the budget of each element."""
    if not lines.inputs:
        return item
    budgets = {e: _with_lines(budget, e, lines) for e, budget in item.budgets.items()}
    k = common_factor(budgets)
    budgets = {element: expanded(budget, k) for element, budget in budgets.items()}
    update = {
        "budgets": budgets,
        "u": item.u | {element: budget.u_c for element, budget in budgets.items()},
        "U": item.U | {element: budget.U for element, budget in budgets.items()},
        "k": k,
    }
    if item.u_without_earth_rotation:
        u = {
            e: None if u is None else math.hypot(u, lines.u(e))
            for e, u in item.u_without_earth_rotation.items()
        }
        update["u_without_earth_rotation"] = u
        update["U_without_earth_rotation"] = {e: None if v is None else k * v for e, v in u.items()}
    return item.model_copy(update=update)


def _with_lines(budget: Budget, element: str, lines: CorrectionLines) -> Budget:
    """A budget with further lines, of infinitely many degrees of freedom, beside its own."""
    u_c = math.hypot(budget.u_c, lines.u(element))
    if u_c == 0.0:
        return budget
    share = (budget.u_c / u_c) ** 2
    before = (line.model_copy(update={"share": line.share * share}) for line in budget.inputs)
    inputs = (*before, *lines.budget_inputs(element, u_c))
    correlations = (*budget.correlations, *lines.correlations(element))
    dof = budget.dof * (u_c / budget.u_c) ** 4 if budget.u_c > 0.0 else math.inf
    k = coverage_factor(dof, budget.coverage_probability)
    shapes = [(line.distribution, line.contribution, line.dof) for line in inputs]
    by_shapes = budget.half_width_95 is not None and not correlations
    return budget.model_copy(
        update={
            "inputs": inputs, "correlations": correlations, "u_c": u_c, "dof": dof, "k": k,
            "U": k * u_c, "half_width_95": half_width(shapes) if by_shapes else None,
        }
    )  # fmt: skip


def _change(item: Item, moved: Item) -> Elements:
    change: Elements = {}
    for element, value in item.value.items():
        other = moved.value.get(element)
        change[element] = None if value is None or other is None else other - value
    return change


def _line(one: UncertainInput, symbol: str, change: float, share: float) -> BudgetInput:
    parameter = one.parameter
    name = message("explain-budget-line", title=one.finding.title, parameter=parameter.name)
    return BudgetInput(
        **text_fields("name", statement(name)), symbol=symbol, kind="A",
        distribution="normal", u=parameter.u, unit=parameter.unit,
        sensitivity=change / parameter.u, contribution=abs(change), share=share,
    )  # fmt: skip


# Calibrates readings corrected for known physics.

Calibrate = Callable[[Recording], Calibration]
EARTH, G_SENSITIVITY = "earth_rotation", "gyro_g_sensitivity"
BY_EARTH = {"earth_not_shown", "earth_contradicted", "latitude_sign"}  # codes of tasks.run_validity


@dataclass(frozen=True)
class Corrections:
    """The clause method on the readings less what findings add, and what of it is uncertain.

    calibration: less what all of them add. inputs: of each finding what is uncertain; correlation:
    of all of those in turn. moved: the items with each greater by its standard uncertainty.
    """

    calibration: Calibration
    inputs: tuple[tuple[UncertainInput, ...], ...]
    correlation: np.ndarray
    moved: tuple[Mapping[str, Item], ...]

    @classmethod
    def of(
        cls, recording: Recording, findings: Sequence[Finding], calibrate: Calibrate,
        determined: DeterminedModel | None,
    ) -> "Corrections":  # fmt: skip
        contributions = [finding.contribution for finding in findings]
        calibration = calibrate(corrected(recording, contributions))
        segments = recording.manifest.segments or calibration.segments
        rows = [recording.imu.rows(one.t_start, one.t_end) for one in segments]
        rows = [one for one in rows if one.stop > one.start]
        values = chain.from_iterable(item.value.values() for item in calibration.items.values())
        asked = () if all(value is None for value in values) else findings  # nothing to be moved
        inputs = tuple(tuple(uncertain_inputs([one], determined, rows)) for one in asked)
        every = list(chain.from_iterable(inputs))
        return cls(
            calibration,
            inputs,
            correlation_of(every, determined),
            tuple(
                calibrate(corrected(recording, (*contributions, one.change(determined)))).items
                for one in every
            ),
        )

    def with_uncertainty(
        self, items: Mapping[str, Item], numbers: Collection[int]
    ) -> dict[str, Item]:
        """Items of readings less what some of the findings add, with what is uncertain of those.

        By how much an element changes is taken from the readings less what all of them add.
        """
        whole = self.calibration.items
        of_finding = np.repeat(np.arange(len(self.inputs)), [len(one) for one in self.inputs])
        used = np.flatnonzero(np.isin(of_finding, list(numbers))).tolist()
        every = list(chain.from_iterable(self.inputs))
        inputs, moved = [every[n] for n in used], [self.moved[n] for n in used]
        correlation = self.correlation[np.ix_(used, used)]
        items = dict(items)
        for name in items.keys() & whole.keys():
            by_input = [each.get(name, whole[name]) for each in moved]
            lines = CorrectionLines.of(inputs, correlation, whole[name], by_input)
            items[name] = with_lines(items[name], lines)
        return items


def adopt(
    recording: Recording,
    findings: Sequence[Finding],
    calibrate: Calibrate,
    determined: DeterminedModel | None,
) -> Calibration:
    """The clause method on the readings less what the findings add.

    determined: of the explanation that the findings are of. U holds the parameters' uncertainties
    beside all the rest, and what the undetermined ones may be:
    u² = u₀² + ΣΣ ∂y/∂pᵢ·u(pᵢ, pⱼ)·∂y/∂pⱼ, each by a difference; with the noise of the clauses' own
    means they are not correlated where these are as good as a fit of all rows. A random walk has
    no parameter whose uncertainty U could hold: it stays in the readings, as noise.
    """
    random = [finding for finding in findings if finding.effect == BIAS_RANDOM_WALK.name]
    findings = [finding for finding in findings if finding.effect != BIAS_RANDOM_WALK.name]
    corrections = Corrections.of(recording, findings, calibrate, determined)
    result = corrections.calibration
    items = corrections.with_uncertainty(result.items, range(len(findings)))
    terms = tuple(_adopted_term(finding, determined) for finding in findings)
    plain = calibrate(recording)  # of the readings as they are
    remarks = (
        *_remarks(result, plain, recording, findings, terms),
        *(
            remark("term_not_taken_off", message("explain-not-adopted-random", term=_named(walk)))
            for walk in random
        ),
        *result.remarks,
    )
    result = result.model_copy(
        update={
            "items": items,
            "terms": terms,
            "information": plain.information,
            "remarks": remarks,
        }
    )
    return _without_earth(result, plain) if EARTH in [f.effect for f in findings] else result


def _adopted_term(finding: Finding, determined: DeterminedModel | None) -> AdoptedTerm:
    """The term with the parameters that were corrected for; for known physics, its check
    parameters.
    """
    every = determined.parameters(finding.terms) if determined else ()
    taken = [one for one in every if not one.held]
    return AdoptedTerm(
        name=finding.effect,
        **text_fields("title", statement(finding.title)),
        parameters=tuple(one.found for one in taken) or finding.parameters,
    )


def _without_earth(result: Calibration, plain: Calibration) -> Calibration:
    """The g-sensitivity of readings without Earth's rotation is the one without it; the site is
    judged by what the readings as they are, `plain`, show of Earth's rotation.
    """
    about_site = (r for r in plain.remarks if r.code in BY_EARTH)
    others = [r for r in result.remarks if r.code not in BY_EARTH and not r.code.startswith(EARTH)]
    result = result.model_copy(update={"remarks": (*others, *about_site)})
    item = result.items.get(G_SENSITIVITY)
    if item is None:
        return result
    kept = {key: one for key, one in result.information.items() if key != WITHOUT_EARTH}
    update = {
        "items": result.items | {G_SENSITIVITY: _with_own_values(item)},
        "information": kept,
    }
    if None not in item.value.values():
        for field in ("unavailable", "unavailable_message", *no_text("unavailable")):
            reasons = getattr(result, field)
            update[field] = {name: why for name, why in reasons.items() if name != G_SENSITIVITY}
    return result.model_copy(update=update)


def _with_own_values(item: Item) -> Item:
    return item.model_copy(
        update={
            "value_without_earth_rotation": item.value,
            "u_without_earth_rotation": item.u,
            "U_without_earth_rotation": item.U,
        }
    )


def _remarks(
    result: Calibration,
    plain: Calibration,
    recording: Recording,
    findings: Sequence[Finding],
    terms: Sequence[AdoptedTerm],
) -> Iterator[Remark]:
    """What was corrected for, with its U, its undetermined part, and where it is unknown.

    plain: of the readings as they are, whose information is given.
    """
    if not findings:
        return
    described = clauses([_described(*each) for each in zip(findings, terms, strict=True)])
    yield remark("terms_adopted", message("explain-adopted", terms=described), blocks_pass=True)
    if plain.information:
        yield remark("information_as_recorded", message("explain-adopted-information"))
    adopted = {finding.effect for finding in findings}
    for finding, term in zip(findings, terms, strict=True):
        taken = {p.name for p in term.parameters}
        left = tuple(p.name for p in finding.parameters if p.name not in taken)
        if left:
            loose = message("explain-adopted-undetermined", term=_named(finding), parameters=left)
            yield remark("parameters_not_taken_off", loose)
        alike = dict.fromkeys((*finding.group, *finding.indistinguishable))
        if others := [name for name in alike if name not in adopted]:
            either = clauses([effect_name(name) for name in others], by="report-or")
            words = message("explain-adopted-alike", term=_named(finding), others=either)
            yield remark("term_not_distinguished", words)
        if finding.delta_bic <= 0.0:
            bic = f"{finding.delta_bic:.1f}"
            not_shown = message("explain-adopted-not-shown", term=_named(finding), bic=bic)
            yield remark("term_not_shown", not_shown)
    segments = _segments_of_unknown_motion(result, recording, findings)
    if segments:
        not_known = message("explain-adopted-motion-unknown", segments=segments)
        yield remark("term_not_known", not_known, segments=segments)


def _named(finding: Finding) -> Message:
    return message("explain-adopted-term", title=finding.title, name=finding.effect)


def _described(finding: Finding, term: AdoptedTerm) -> Message:
    """A finding with the parameters that were corrected for."""
    if not term.parameters:
        return _named(finding)
    values = (f"{p.name} = {quantity(p.value, USUAL_K * p.u, p.unit)}" for p in term.parameters)
    return message(
        "explain-adopted-term-parameters",
        title=finding.title, name=finding.effect, parameters=tuple(values),
    )  # fmt: skip


def _segments_of_unknown_motion(
    result: Calibration, recording: Recording, findings: Sequence[Finding]
) -> tuple[str, ...]:
    """The segments used that have rows without a known contribution."""
    unknown = np.zeros(len(recording.imu), dtype=bool)
    for finding in findings:
        unknown |= ~np.isfinite(finding.contribution[:, list(finding.channels)]).all(axis=1)
    used = ((s.name, recording.imu.rows(s.t_start, s.t_end)) for s in result.segments)
    return tuple(name for name, rows in used if unknown[rows].any())


def corrected(recording: Recording, contributions: Sequence[np.ndarray]) -> Recording:
    """The recording less what each contribution (n, 6), rad/s and m/s², added to its readings.

    Rows where a contribution is not known stay as they were read.
    """
    added = np.zeros((len(recording.imu), len(CHANNELS)))
    for contribution in contributions:
        added += np.nan_to_num(contribution, nan=0.0)
    columns = dict(recording.imu.columns)
    for channel, name in enumerate(CHANNELS):
        if name in columns and added[:, channel].any():
            columns[name] = columns[name] - added[:, channel]
    return replace(recording, imu=Stream(recording.imu.t, columns))
