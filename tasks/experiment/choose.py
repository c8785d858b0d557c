"""Chooses the shortest procedure of a station's blocks that tells competing models apart."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import ceil

import numpy as np

from schemas.base import Unusable
from schemas.procedure import Position, Procedure
from schemas.recording import Manifest, Recording
from schemas.text import CONTRACTED, text_fields
from tasks.experiment.blocks import (
    NOISE_S,
    ROOM,
    Abilities,
    Block,
    Step,
    blocks_of,
    noise_rest,
    room_of,
    stands_still,
    steps_of,
)
from tasks.experiment.separation import (
    FINE_HZ,
    STILL_HZ,
    Choice,
    Separation,
    UnitNoise,
    enough,
    left_by_real_fit,
)
from tasks.experiment.track import ThermalResponse, planned_recording
from tasks.explain.evidence.confounding import DELAYING, DISTINGUISHABLE, GYROS_ALONE
from tasks.explain.evidence.form_errors import undetermined
from tasks.explain.explain import explain, fitted_effects
from tasks.explain.explanation import COVERAGE, UNNAMED, Explanation
from tasks.explain.inputs.blocks import Blocks
from tasks.explain.noise import Noise
from tasks.explain.progress import Progress, silent
from tasks.explain.search.fitted import FittedSelection, fitted
from tasks.explain.search.stepwise import HOLDS, SHOWN, places_apart
from tasks.model.model import Model
from tasks.model.term import EVENTS
from tasks.station.plan import plan
from tasks.words import message, statement

SPARE = 0.9  # of the blocks: fewer are tried where so many would be enough
REPEATS = 25  # of one block
SETTLE_S = 0.1
PRICE = 4.0  # chi-squared of each parameter: ln(1 + n) with some fifty stretches that tell of it
LITTLE = 0.02  # share of what should be shown: by no more than its inverse more is tried at once
NOTHING = ""  # the standard's model with none of the competing effects

Pair = tuple[str, str]


@dataclass(frozen=True)
class Experiment:
    """Competing models by name, the unit's noise, and what the station can do with it.

    rivals: what else would fit a recording of one of them, and is not suspected itself. like:
    manifest of the unit's recording, with the station's part. name: of the procedure. base: the
    procedure whose warm-up, settling, rates of moves and room it keeps, if there is one. thermal:
    how the unit follows the chamber, where it can be set. by_silence: the one that is left where
    none of the others shows.
    """

    models: Mapping[str, Model]
    noise: UnitNoise
    abilities: Abilities
    like: Manifest
    name: str
    base: Procedure | None = None
    rivals: Mapping[str, Model] = field(default_factory=dict)
    thermal: ThermalResponse | None = None
    by_silence: str = NOTHING

    @property
    def every(self) -> Mapping[str, Model]:
        """The models that compete, and their rivals."""
        return {**self.models, **self.rivals}

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """True and other models; none with another that holds it, which fits whatever it does."""
        return tuple(
            (truth, other)
            for truth, other in product(self.models, self.every)
            if truth not in (NOTHING, other, self.by_silence) and HOLDS.get(truth) != other
        )

    def planned(self, procedure: Procedure) -> Recording:
        """What the table and the unit's thermometer would record of a procedure."""
        rate = STILL_HZ if stands_still(procedure.steps) else FINE_HZ
        return planned_recording(self._as_driven(procedure), self.like, rate, self.thermal)

    def _as_driven(self, procedure: Procedure) -> Procedure:
        """With ramps of a constant acceleration that show as much as those of the station."""
        acceleration = procedure.acceleration_deg_s2 * self.abilities.ramp_share
        return procedure.model_copy(update={"acceleration_deg_s2": acceleration})

    def bound(self, pair: Pair) -> float:
        """Chi-squared that names the true one alone: a pair's difference; of a special case what a
        departure from it shows; beside nothing as much, with the price of its parameters.
        """
        truth, other = pair
        if HOLDS.get(other) == truth:
            return SHOWN
        if other != NOTHING:
            return DISTINGUISHABLE
        places = self.models[truth].places
        count = sum(own.stop - own.start for key, own in places.items() if key[0] == truth)
        return DISTINGUISHABLE + PRICE * (count - 1)

    def shortest(self, minutes: float) -> Choice:
        """Blocks added one by one, each time the one that shows most for its time, until the whole
        is enough or no time is left; linear forms choose, real fits judge.
        """
        chosen: list[_Measured] = []
        needed = 1.0
        while True:
            more = self._extended(chosen, needed, minutes)
            choice = self._judged(more or self._measured[:1])
            if choice.is_enough:
                return self._shortened(more, choice)
            if len(more) == len(chosen):
                return choice
            by_linear = max(self._share(_total(more)), needed)  # a long block shows more at once
            chosen, needed = more, 1.05 * by_linear / max(choice.share, LITTLE)

    def _shortened(self, chosen: Sequence["_Measured"], choice: Choice) -> Choice:
        """With as few of the blocks as real fits, which show more than linear ones, need."""
        share = 1.0 / choice.share
        while share < SPARE:
            fewer = self._judged(chosen[: max(1, ceil(len(chosen) * share / SPARE))])
            if fewer.is_enough:
                return fewer
            share *= 1.0 / max(fewer.share, LITTLE)
        return choice

    def left_by(self, blocks: Blocks, noises: Sequence[Noise]) -> float:
        """The least chi-squared by which a motion, in blocks, separates two that compete."""
        return min(
            left_by_real_fit(self.models[other], self._reading(blocks, truth), noises)
            for truth, other in self.pairs
            if other in self.models
        )

    def _reading(self, blocks: Blocks, truth: str) -> Blocks:
        prediction = self.models[truth].prediction(blocks.motion)
        return replace(blocks, readings=np.nan_to_num(prediction))

    def _extended(
        self, chosen: Sequence["_Measured"], needed: float, minutes: float
    ) -> list["_Measured"]:
        """With as many blocks more as linear forms need. Where they do not get there, a long block
        that shows little at first may still show more than all that was taken in its place.
        """
        more = self._one_by_one(chosen, needed, minutes)
        fitting = [one for one in self._measured if one.seconds <= 60.0 * minutes]
        if chosen or not fitting or self._share(_total(more)) >= needed:
            return more
        most = max(fitting, key=lambda one: self._share(one.separations))
        other = self._one_by_one([most], needed, minutes)
        return max(more, other, key=lambda some: self._share(_total(some)))

    def _one_by_one(
        self, chosen: Sequence["_Measured"], needed: float, minutes: float
    ) -> list["_Measured"]:
        more, so_far = list(chosen), _total(chosen)
        while self._share(so_far) < needed:
            used = Counter(one.block.name for one in more)
            left_s = 60.0 * minutes - sum(one.seconds for one in more)
            open_ = [one for one in self._measured
                     if used[one.block.name] < REPEATS and one.seconds <= left_s]  # fmt: skip
            if not open_:
                break
            sums = [_sum(so_far, one.separations) for one in open_]
            worth = [(self._share(s) - self._share(so_far)) / one.seconds
                     for s, one in zip(sums, open_, strict=True)]  # fmt: skip
            best = max(range(len(open_)), key=worth.__getitem__)
            more.append(open_[best])
            so_far = sums[best]
        while len(more) > len(chosen) and self._minutes(more) > minutes:  # the way between them
            more.pop()
        return more

    def _share(self, so_far: Mapping[Pair, Separation]) -> float:
        """For the hardest pair, the achieved share of the required excess of the wrong model."""
        left = {pair: one.left for pair, one in so_far.items()}
        beyond = (
            (left[pair] - left[pair[0], pair[0]]) / enough(self.bound(pair))
            for pair in left
            if pair[0] != pair[1]
        )
        return max(min(beyond, default=0.0), 0.0)

    def _judged(self, chosen: Sequence["_Measured"]) -> Choice:
        return self.judged(self._procedure(steps_of([one.block for one in chosen])))

    def judged(self, procedure: Procedure) -> Choice:
        """A procedure, by real fits."""
        planned = self.planned(procedure)
        shown: dict[Pair, float] = {}
        for truth in dict.fromkeys(truth for truth, _ in self.pairs):
            observed = self.noise.observed(planned, self.models[truth])
            noises = self.noise.at(observed)
            own = left_by_real_fit(self.models[truth], observed, noises)
            for first, other in self.pairs:
                if first == truth:
                    left = left_by_real_fit(self.every[other], observed, noises) - own
                    shown[first, other] = max(left, 0.0)
        worst = min(shown, key=lambda pair: shown[pair] / enough(self.bound(pair)))
        least = min(left for (_, other), left in shown.items() if other in self.models)
        return Choice(procedure, minutes_of(procedure), shown[worst], self.bound(worst), least)

    def _minutes(self, chosen: Sequence["_Measured"]) -> float:
        return minutes_of(self._procedure(steps_of([one.block for one in chosen])))

    @cached_property
    def _measured(self) -> tuple["_Measured", ...]:
        blocks = blocks_of(self.abilities)
        return tuple(self._measure(one) for one in blocks if not (one.moves and self._drifts))

    @property
    def _drifts(self) -> bool:
        """Whether time alone moves what competes, whatever the table does."""
        terms = (term for model in self.models.values() for term in model.terms)
        return all(term.time_course == "drift" for term in terms if term.name in self.models)

    def _measure(self, block: Block) -> "_Measured":
        """By its second turn: the way to where it begins is gone once, however often it comes. What
        fades since the unit was switched on by its first. The truth reads the motion that encoders
        tell: what they miss at corners would count as a difference, and the real fits have it.
        """
        turns = 1 if self._drifts else 2
        planned = self.planned(self._procedure(steps_of([block] * turns)))
        segments = planned.manifest.segments or ()
        begins = 0.0 if self._drifts else segments[-1 - len(segments) // 2].t_end
        ends = segments[-1].t_end
        found: dict[Pair, Separation] = {}
        for truth in dict.fromkeys(truth for truth, _ in self.pairs):
            observed = self._reading(self.noise.observed(planned, self.models[truth]), truth)
            second = observed.weight * (observed.t > begins)[:, None]
            observed, noises = replace(observed, weight=second), self.noise.at(observed)
            for name in (truth, *(other for first, other in self.pairs if first == truth)):
                found[truth, name] = Separation.of(self.every[name], observed, noises)
        return _Measured(block, ends - begins, found)

    def _procedure(self, steps: Sequence[Step]) -> Procedure:
        """On a unit that is warm, unless the base lets it warm up; with a rest that tells the noise
        first, where no step is one.
        """
        base, able, title = self.base, self.abilities, statement(message("next-title"))
        rests = [step for step in steps if isinstance(step, Position) and step.dwell_s >= NOISE_S]
        steps = steps if rests else (noise_rest(able), *steps)
        slowest, acceleration = min(able.rates_deg_s), able.acceleration_deg_s2
        return Procedure(
            name=self.name, **text_fields("title", title, CONTRACTED), standard="other",
            environment=room_of(steps, base.environment if base else ROOM),
            warm_up_s=base.warm_up_s if base else 0.0,
            settle_s=base.settle_s if base else SETTLE_S,
            move_rate_deg_s=min(base.move_rate_deg_s, slowest) if base else slowest,
            acceleration_deg_s2=acceleration,
            steps=tuple(steps),
        )  # fmt: skip


@dataclass(frozen=True)
class _Measured:
    """A block, s that it takes, and what it shows of each pair."""

    block: Block
    seconds: float
    separations: Mapping[Pair, Separation]


def minutes_of(procedure: Procedure) -> float:
    """What a station is expected to take for it."""
    return (procedure.warm_up_s + sum(each.planned_s for each in plan(procedure))) / 60.0


def _total(some: Sequence[_Measured]) -> dict[Pair, Separation]:
    total: dict[Pair, Separation] = {}
    for one in some:
        total = _sum(total, one.separations)
    return total


def _sum(
    first: Mapping[Pair, Separation], more: Mapping[Pair, Separation]
) -> dict[Pair, Separation]:
    return {pair: first[pair] + one if pair in first else one for pair, one in more.items()}


# What an explanation left open: effects it could not tell apart, or only suspected.

SUSPECTED = ("undetermined", "channel_worse", "overshadowed", "reference_noise")


@dataclass(frozen=True)
class OpenQuestion:
    """names: of the competing effects; one alone competes with none. models: of each, fitted to the
    recording with everything else that was named, which the others are. fit: of the first.
    typical: as models, but a suspected effect has its expected size; in models it has the smallest
    size that the recording allows.
    """

    names: tuple[str, ...]
    models: Mapping[str, Model]
    typical: Mapping[str, Model]
    fit: FittedSelection
    others: tuple[str, ...] = ()


def open_question(
    recording: Recording, asked: Sequence[str] = (), progress: Progress = silent
) -> OpenQuestion | None:
    """The effects that were asked for, else what the recording's explanation left open first.

    None where it names everything by itself. Raises Unusable for what the recording cannot show.
    """
    explanation = explain(recording, progress=progress)
    names = tuple(asked) or next(_open(explanation), ())
    if not names:
        return None
    others = [name for name in _named_alone(explanation) if name not in names]
    if len(names) > 1 and GYROS_ALONE not in names and set(names) <= set(DELAYING):
        others.append(GYROS_ALONE)  # triads may be late unlike each other, whatever makes them late
    fits = {name: fitted_effects(recording, [name, *others]) for name in names}
    first = fits[names[0]]
    models = {name: fit.model for name, fit in fits.items()}
    for special, general in HOLDS.items():
        if special in models and general in models:
            models[general] = _apart(models[general], general, models[special], special)
    typical = dict(models)
    if len(names) == 1:
        models = {names[0]: _sized(first, names[0])}
        typical = {names[0]: _typical(first, models[names[0]], names[0])}
    # What is to be named alone has to show beside nothing, too.
    own = {key for key in first.model.places if key[0] == names[0]}
    models[NOTHING] = typical[NOTHING] = models[names[0]].without(own)
    return OpenQuestion(names, models, typical, first, tuple(others))


def _open(explanation: Explanation) -> Iterator[tuple[str, ...]]:
    findings = (*explanation.findings, *explanation.small)
    for finding in findings:
        if len(finding.group) > 1:
            yield finding.group
        elif finding.indistinguishable and finding.effect != UNNAMED:
            # An event in the samples has no model; what it may be mistaken for has.
            others = (name for name in finding.indistinguishable if name not in EVENTS)
            yield (finding.effect, *others)
    for finding in findings:
        if finding.refusal is not None and finding.refusal.kind in SUSPECTED:
            name = finding.refusal.name
            yield (name, HOLDS[name]) if name in HOLDS else (name,)


def _sized(fit: FittedSelection, name: str) -> Model:
    """With what the recording determines of the effect; where that is nothing, with the clearest
    of its parameters as large as its U.
    """
    model = fit.model
    own = [p for key, place in model.places.items() if key[0] == name for p in _range(place)]
    loose = undetermined(model, [set(own)], np.ones(len(model.values)))
    sized = fitted(model.held_at_zero(loose), fit.blocks, fit.noises)
    values = sized.values.copy()
    for p in own:
        if not loose[p]:
            least = COVERAGE * sized.u[p]
            values[p] = np.copysign(max(abs(values[p]), least), values[p])
    return replace(sized, values=values, free=model.free)


def _typical(fit: FittedSelection, sized: Model, name: str) -> Model:
    """With the root mean square of each parameter, given the recording.

    Beforehand a parameter is normal about zero, and those of one unit are alike: their variance is
    what the determined ones have beyond their own, τ² = mean(v² − u²). Given v ± u the mean is κv
    and the variance κu², κ = τ²/(τ² + u²); of what the recording does not determine, 0 and τ².
    """
    values = sized.values.copy()
    for term in sized.terms:
        if term.name != name:
            continue
        place = sized.places[term.key]
        v, u = fit.model.values[place], fit.model.u[place]
        known = sized.values[place] != 0.0
        units = np.array([parameter.unit for parameter in term.parameters])
        for unit in dict.fromkeys(units[known]):
            own = units == unit
            variance = float(np.mean((v**2 - u**2)[own & known]))
            if variance <= 0.0:
                continue  # as small as the recording allows
            kappa = variance / (variance + u**2)
            power = (kappa * v) ** 2 + kappa * u**2
            values[place] = np.where(own, np.copysign(np.sqrt(power), v), values[place])
    return replace(sized, values=values)


def _apart(model: Model, general: str, of_special: Model, special: str) -> Model:
    """The general effect as a typical departure from its special case: what the recording leaves
    open of it is not what it was fitted to.
    """
    r = next(
        of_special.values[place] for key, place in of_special.places.items() if key[0] == special
    )
    values = model.values.copy()
    for key, place in model.places.items():
        if key[0] == general:
            values[place] = places_apart(r)
    return replace(model, values=values)


def _range(place: slice) -> range:
    return range(place.start, place.stop)


def _named_alone(explanation: Explanation) -> list[str]:
    return [
        one.effect
        for one in explanation.findings
        if one.effect != UNNAMED and one.terms and not one.group
    ]


# Explains a simulated recording of the proposed procedure: which other names would fit it.


def rivals_of(
    choice: Choice, experiment: Experiment, name: str, others: Sequence[str]
) -> Mapping[str, Model]:
    """The effects that `explain` cannot separate from one in the proposed recording, or names in
    its place, each fitted to it together with the other effects present.
    """
    planned = experiment.planned(choice.procedure)
    rehearsed = experiment.noise.recording(planned, experiment.models[name])
    found: dict[str, Model] = {}
    for rival in _names_beside(name, rehearsed, others):
        try:
            found[rival] = fitted_effects(rehearsed, [rival, *others]).model
        except Unusable:
            continue  # it does not show that one by itself
    return found


def _names_beside(name: str, rehearsed: Recording, others: Sequence[str]) -> list[str]:
    findings = [
        {one.effect, *one.group, *one.indistinguishable} - {UNNAMED, *others}
        for one in explain(rehearsed).findings
    ]
    own = next((names for names in findings if name in names), None)
    if own is None:
        own = next((names for names in findings if names), set())
    return sorted(own - {name})
