"""From a fitted model to findings: what each piece of physics earns, and its parameters."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter, HeldOut, Verdict
from schemas.recording import Recording
from tasks.explain.events.event import Event, Events
from tasks.explain.explanation import CHANNELS, Explanation, Finding
from tasks.explain.generic import UNNAMED
from tasks.explain.held_out import HalfSeen, half_seen
from tasks.explain.observed import FullRate, Observed
from tasks.explain.pool import inverse
from tasks.explain.refit import Equations, Model, equations_of, fitted, model_of
from tasks.explain.search import NEAR, Chosen, Found
from tasks.explain.spectrum import Noise
from tasks.model.events import EVENT_TEXTS
from tasks.model.simulate import linearise, predict
from tasks.model.term import Column, Parameter, Term, Text, places

SEEN = 0.02  # of a finding's power: a channel with less is not named
STEPS_ARE_JUMPS = 2  # as many steps or more are no single step


@dataclass(frozen=True)
class Group:
    """One finding to be: its name, the terms that model it, and who else might."""

    name: str
    terms: tuple[Term, ...]
    chosen: tuple[Chosen, ...]


def assembled(
    recording: Recording,
    full: FullRate,
    fine: Observed,
    events: Events,
    found: Found,
    model: Model,
    noises: Sequence[Noise],
) -> Explanation:
    """The explanation that a fitted model is, with the events in front."""
    standard = fitted(model_of(()), fine, noises)
    noise = np.sqrt(np.nanmedian(full.shaking, axis=0)).repeat(3)
    t = full.motion.t
    bare = predict(model.terms, full.motion, model.values)
    groups = _groups(found)
    weighed = _Weighed.of(model, fine, noises, groups)
    findings = [
        _finding(group, number, weighed, model, full, bare, fine, noises)
        for number, group in enumerate(groups)
    ]
    findings.sort(key=lambda each: -each.gain)
    happened = _of_events(events, t, full, bare, noise)
    with_events = events.applied(t, bare, noise) if events.events else bare
    nominal = predict(standard.terms, full.motion, standard.values)
    whole = (*happened, *findings)
    return Explanation(
        recording=recording,
        nominal=nominal,
        found=with_events,
        noise=noise,
        p_value=min([found.p_value, *(event.p_value for event in events.events)]),
        verdict=_verdict(whole),
        held_out=weighed.held_out(),
        findings=whole,
        remarks=events.remarks,
    )


def _verdict(findings: Sequence[Finding]) -> Verdict:
    if not findings:
        return "no_mismatch"
    unnamed = [each.effect == UNNAMED for each in findings]
    if all(unnamed):
        return "unexplained"
    return "partly_explained" if any(unnamed) else "explained"


def _groups(found: Found) -> list[Group]:
    """Findings of one name are one, but those without a name; several steps are jumps."""
    named: dict[str, list[Chosen]] = {}
    for n, one in enumerate(found.chosen):
        key = one.candidate.name if one.candidate.name != UNNAMED else f"{UNNAMED} {n}"
        named.setdefault(key, []).append(one)
    return [
        Group(
            _name_of(some),
            tuple({id(one.candidate.term): one.candidate.term for one in some}.values()),
            tuple(some),
        )
        for some in named.values()
    ]


def _name_of(some: Sequence[Chosen]) -> str:
    times = {one.candidate.term.at for one in some}
    if some[0].candidate.name == "bias_step" and len(times) >= STEPS_ARE_JUMPS:
        return UNNAMED
    return some[0].candidate.name


@dataclass(frozen=True)
class _Weighed:
    """The model's columns, whitened, on all rows and on the two halves.

    groups: for each finding the columns that are its own and what they are multiplied by now.
    prior: (q,) precision beforehand.
    """

    whole: Equations
    halves: HalfSeen
    groups: tuple[tuple[list[int], np.ndarray], ...]
    fixed: tuple[int, ...]
    prior: np.ndarray
    used: int

    @classmethod
    def of(
        cls, model: Model, fine: Observed, noises: Sequence[Noise], groups: Sequence[Group]
    ) -> "_Weighed":
        design = linearise(model.terms, fine.motion, model.values)
        free = np.flatnonzero(model.free)
        columns: list[Column] = [design.columns[p] for p in free]
        prior = model.prior[free]
        own, position = places(model.terms), {int(p): q for q, p in enumerate(free)}
        indexed, fixed = [], []
        for group in groups:
            mine, now = [], []
            for k, term in enumerate(model.terms):
                if not any(term is each for each in group.terms):
                    continue
                if not term.parameters:
                    effect = design.prediction - predict(
                        model.without(term).terms, fine.motion, model.without(term).values
                    )
                    fixed.append(len(columns))
                    mine.append(len(columns))
                    now.append(1.0)
                    columns.append({c: effect[:, c] for c in range(6)})
                for p in range(own[k].start, own[k].stop):
                    if p in position:
                        mine.append(position[p])
                        now.append(float(model.values[p]))
            indexed.append((mine, np.array(now)))
        misfit = fine.readings - design.prediction
        prior = np.concatenate([prior, np.zeros(len(columns) - len(prior))])
        return cls(
            equations_of(columns, misfit, fine, noises),
            half_seen(columns, misfit, fine, noises),
            tuple(indexed), tuple(fixed), prior, int((fine.weight > 0).sum()),
        )  # fmt: skip

    def _kept(self, without: Sequence[int]) -> list[int]:
        return [q for q in range(self.whole.count) if q not in without and q not in self.fixed]

    def _added(self, numbers: Sequence[int]) -> np.ndarray:
        added = np.zeros(self.whole.count)
        for number in numbers:
            mine, now = self.groups[number]
            added[mine] = now
        return added

    def gain(self, number: int) -> float:
        """Chi-squared lost when one finding is left out and all else is fitted again."""
        return self._chi2(self._kept(self.groups[number][0]), self._added([number])) - self._chi2(
            self._kept(()), np.zeros(self.whole.count)
        )

    def _chi2(self, kept: Sequence[int], added: np.ndarray) -> float:
        normal, right, misfit = self.whole.normal()
        right = right + normal @ added
        chi2 = misfit + 2.0 * added @ self.whole.normal()[1] + added @ normal @ added
        rows = list(kept)
        block = normal[np.ix_(rows, rows)] + np.diag(self.prior[rows])
        return float(chi2 - right[rows] @ inverse(block) @ right[rows])

    def held_out_gain(self, number: int) -> float:
        """Log-likelihood (nats) that one finding adds on segments that a fit did not see."""
        without = self.halves.chi2(
            self._kept(self.groups[number][0]), self._added([number]), self.prior
        )
        return 0.5 * float((without - self._after()).sum())

    def _after(self) -> np.ndarray:
        return self.halves.chi2(self._kept(()), np.zeros(self.whole.count), self.prior)

    def held_out(self) -> HeldOut:
        """How segments that a fit did not see are predicted, before and after."""
        every = range(len(self.groups))
        mine = [q for number in every for q in self.groups[number][0]]
        before = self.halves.chi2(self._kept(mine), self._added(list(every)), self.prior)
        after = self._after()
        ratio = {
            name: float(np.sqrt(after[c] / before[c]))
            for c, name in enumerate(CHANNELS)
            if before[c] > 0
        }
        return HeldOut(
            rms_ratio=ratio,
            chi2_per_dof_before=float(before.sum() / self.used),
            chi2_per_dof_after=float(after.sum() / self.used),
        )


def _finding(
    group: Group,
    number: int,
    weighed: _Weighed,
    model: Model,
    full: FullRate,
    bare: np.ndarray,
    fine: Observed,
    noises: Sequence[Noise],
) -> Finding:
    rest = model
    for term in group.terms:
        rest = rest.without(next(each for each in rest.terms if each is term))
    contribution = bare - predict(rest.terms, full.motion, rest.values)
    gain = weighed.gain(number)
    count = sum(len(one.candidate.own) for one in group.chosen if not one.candidate.known)
    if group.chosen[0].candidate.prior is not None:
        count = len(group.chosen)
    first = group.terms[0]
    named = group.name != UNNAMED
    title = first.title if named or first.name == UNNAMED else JUMPS
    return Finding(
        effect=group.name,
        family=first.family if named else UNNAMED,
        title=title,
        equation=first.equation,
        source=first.source,
        channels=_channels(contribution, full),
        parameters=_parameters(group, model, fine, noises),
        contribution=contribution,
        gain=gain,
        delta_bic=gain - count * float(np.log(weighed.used)),
        held_out_gain=weighed.held_out_gain(number),
        indistinguishable=_alike(group) if named else (),
        separated_by=first.separated_by if named else ("", ""),
        follows=None if named else title,
    )


JUMPS: Text = ("jumps between levels at several times", "在多个时刻的电平跳变")


def _alike(group: Group) -> tuple[str, ...]:
    """Catalogue names that fit so nearly as well that the data do not tell them apart."""
    alike: dict[str, None] = {}
    for one in group.chosen:
        for rival in one.rivals:
            if rival.candidate.name != UNNAMED and one.gain - rival.gain < NEAR:
                alike[rival.candidate.name] = None
    return tuple(alike)


def _channels(contribution: np.ndarray, full: FullRate) -> tuple[int, ...]:
    """The channels with a share of the power, in units of their noise."""
    variance = np.nanmedian(full.shaking, axis=0).repeat(3)
    power = np.nansum(contribution**2, axis=0) / np.where(variance > 0, variance, np.inf)
    if not power.any():
        return ()
    return tuple(int(c) for c in np.flatnonzero(power > SEEN * power.sum()))


def _parameters(
    group: Group, model: Model, fine: Observed, noises: Sequence[Noise]
) -> tuple[FoundParameter, ...]:
    found: list[FoundParameter] = []
    own = places(model.terms)
    u = np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
    random = group.chosen[0].candidate.prior is not None
    for k, term in enumerate(model.terms):
        if not any(term is each for each in group.terms) or random:
            continue
        freed = term.freed()
        if freed is not None:
            found.extend(_freed_parameters(model, term, freed, fine, noises))
        for p, parameter in zip(range(own[k].start, own[k].stop), term.parameters, strict=True):
            if model.free[p]:
                found.append(_said(parameter, float(model.values[p]), float(u[p])))
        for shape, value in zip(term.shapes, term.at, strict=True):
            found.append(_said(shape, value, model.shape_u[k] or 0.0))
    return tuple(found)


def _freed_parameters(
    model: Model, term: Term, freed: Term, fine: Observed, noises: Sequence[Noise]
) -> list[FoundParameter]:
    """Parameters of known physics as the data alone have them, all else fitted beside them."""
    rest = model.without(term)
    free = np.concatenate([rest.free, np.ones(len(freed.parameters), bool)])
    count = len(freed.parameters)
    longer = Model(
        (*rest.terms, freed),
        np.concatenate([rest.values, [p.nominal for p in freed.parameters]]),
        free,
        np.concatenate([rest.prior, np.zeros(count)]),
        np.zeros((len(free), len(free))),
        (*rest.shape_u, None),
    )
    alone = fitted(longer, fine, noises)
    u = np.sqrt(np.maximum(np.diag(alone.covariance), 0.0))
    return [
        FoundParameter(
            name=parameter.name,
            value=float(value * parameter.factor),
            unit=parameter.unit,
            u=float(known * parameter.factor),
        )
        for parameter, value, known in zip(
            freed.parameters, alone.values[-count:], u[-count:], strict=True
        )
    ]


def _said(parameter: Parameter, value: float, u: float) -> FoundParameter:
    """In SI, so that whoever compares it need not know how it is printed."""
    unit = parameter.unit if parameter.factor == 1.0 else si_unit(parameter.unit)
    return FoundParameter(name=parameter.name, value=value, unit=unit, u=u)


def si_unit(printed: str) -> str:
    """The SI unit of what is printed in a unit of the house."""
    for shown, kept in (("arcsec", "rad"), ("deg", "rad"), ("mT", "T"), ("/g", "/(m/s2)")):
        printed = printed.replace(shown, kept)
    return printed


def _of_events(
    events: Events, t: np.ndarray, full: FullRate, bare: np.ndarray, noise: np.ndarray
) -> list[Finding]:
    """Findings of the events, each with what it changes after those before it."""
    found, reading = [], bare
    for event in events.events:
        after = event.applied(t, reading, noise)
        found.append(_of_event(event, after - reading, full, noise))
        reading = after
    return found


def _of_event(
    event: Event, contribution: np.ndarray, full: FullRate, noise: np.ndarray
) -> Finding:
    texts = EVENT_TEXTS.get(event.effect)
    variance = np.where(noise > 0, noise**2, np.inf)
    gain = float((np.nansum(contribution**2, axis=0) / variance).sum())
    count = len(event.parameters)
    rows = max(1, int(np.isfinite(full.readings[:, list(event.channels)]).sum()))
    return Finding(
        effect=event.effect,
        family=texts.family if texts else UNNAMED,
        title=texts.title if texts else event.description,
        equation=texts.equation if texts else "",
        source=texts.source if texts else "",
        channels=event.channels,
        parameters=event.parameters,
        contribution=contribution,
        gain=gain,
        delta_bic=gain - count * float(np.log(rows)),
        held_out_gain=0.5 * gain - count,
        separated_by=texts.separated_by if texts else ("", ""),
        follows=None if texts else event.description,
    )


