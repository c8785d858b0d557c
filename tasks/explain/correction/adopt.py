"""Calibrates readings corrected for known physics, with the uncertainty of the corrections."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from schemas.calibration import AdoptedTerm, Calibration, Item
from schemas.recording import Recording, Stream
from schemas.text import Remark, no_text, text_fields
from tasks.calibrate.information.entry import WITHOUT_EARTH
from tasks.explain.correction.sensitivity import (
    CorrectionLines,
    UncertainInput,
    correlation_of,
    uncertain_inputs,
    with_lines,
)
from tasks.explain.explanation import CHANNELS, DeterminedModel, Finding
from tasks.model.term import effect_name
from tasks.model.terms.memory import BIAS_RANDOM_WALK
from tasks.words import Message, clauses, message, remark, statement
from tasks.words.numbers import USUAL_K, quantity

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
