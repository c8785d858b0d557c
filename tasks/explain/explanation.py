"""The result of `explain` as arrays; its report in words is a discrepancy."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from schemas.discrepancy import FoundParameter, HeldOut, Verdict
from schemas.recording import Recording
from tasks.explain.determined import DeterminedModel
from tasks.model.term import TermKey
from tasks.words import Sayable, message

UNNAMED = "unnamed"
FITTED = message("explain-model-fitted")

Partition = Literal["time", "rate", "up", "triad", "axis"]
RefusalKind = Literal[
    "implausible",
    "inhomogeneous",
    "channel_worse",
    "undetermined",
    "overshadowed",
    "form_error",
    "reference_noise",
    "placed",
    "one_end",
    "both_ways",
    "swings",
    "switching",
]


@dataclass(frozen=True)
class Refusal:
    """Why a catalogue name was withdrawn from a finding, and the numbers that speak against it.

    kind: implausible: a parameter's `value` lies beyond the plausible `limit`. inhomogeneous: it
    runs from `smallest` to `largest` in different `parts` of the recording. channel_worse: the
    `channel` (0 to 5) that its equation touches is predicted worse with it, by `value` nats.
    undetermined: no parameter is larger than its U; `value`, `limit`: the clearest and its U.
    overshadowed: what stays unexplained in its channels is `value` times what it removes, and up
    to `limit` times the noise's variance.
    form_error: what else was found there has `value` times its evidence, and forms of its own.
    reference_noise: it fits no better than what makes the reference's own noise smaller.
    placed: labels alone tell `value` positions, and it has a parameter for all that they leave.
    one_end: it is a jump with no more than `value` cells of the recording before or after it.
    both_ways: a memory of which parts run round their loops one way, and parts the other.
    swings: a low-pass of accelerometers whose amplitude changes as no filter's does.
    switching: a random walk that changes at two moments, and hardly between.
    name: the catalogue's. parameter: the one in question, its numbers in `unit` (SI).
    parts: what divides the recording: time, rate, upward axis, triad, axis.
    """

    kind: RefusalKind
    name: str
    parameter: str | None = None
    unit: str = "1"
    value: float | None = None
    limit: float | None = None
    smallest: float | None = None
    largest: float | None = None
    channel: int | None = None
    parts: Partition | None = None


@dataclass(frozen=True, eq=False)
class Finding:
    """One piece of physics that the model left out.

    effect: its catalogue name, or UNNAMED. channels: indices 0 to 5 of those that show it.
    contribution: (n, 6) rad/s and m/s², what it adds to the readings, at the unit's rows.
    gain: chi-squared that it explains beyond all the rest, counted against what is left.
    share: of the mismatch above noise that it removes. homogeneity_p: that its parameters are the
    same in all parts of the recording; None where no parts determine them. group: catalogue names
    that make up for each other here, its own included; common: what their combinations have in
    common. terms: keys of its terms in the explanation's determined model; an event has none.
    refusal: why its name was withdrawn. behaviour: what it is called without a name; empty
    for physics that is known beforehand. unlisted: in a form that no publication lists. remainder:
    it is what nothing explains, and removes none.
    """

    effect: str
    family: str
    title: Sayable
    equation: str
    source: str
    channels: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    contribution: np.ndarray
    gain: float
    delta_bic: float
    held_out_gain: float
    indistinguishable: tuple[str, ...] = ()
    separated_by: Sayable | None = None
    share: float = 0.0
    homogeneity_p: float | None = None
    group: tuple[str, ...] = ()
    common: tuple[FoundParameter, ...] = ()
    refusal: Refusal | None = None
    terms: tuple[TermKey, ...] = ()
    behaviour: Sayable = ""
    unlisted: bool = False
    remainder: bool = False

    @property
    def follows(self) -> Sayable | None:
        """What an unnamed finding follows, which is all that it is called by."""
        return self.title if self.effect == UNNAMED else None


@dataclass(frozen=True)
class Explanation:
    """Everything that `explain` found in one recording.

    nominal, found: (n, 6) predicted readings at the unit's rows, without and with the findings;
    NaN where the motion is not known. noise: (6,) standard deviation of one sample at rest.
    p_value: of the strongest mismatch, corrected for how many were looked for.
    findings: ordered by share. model: what `nominal` is of. left_over: (6,) chi-squared per degree
    of freedom of what is left after all of them, against the sensor's noise at rest; NaN where a
    channel was not recorded. explained_share: of the mismatch above noise. small: findings that
    remove less of it than a stated share. determined: the model by which findings are taken off.
    """

    recording: Recording
    nominal: np.ndarray
    found: np.ndarray
    noise: np.ndarray
    p_value: float
    verdict: Verdict
    held_out: HeldOut
    findings: tuple[Finding, ...]
    remarks: tuple[Sayable, ...] = ()
    model: Sayable = FITTED
    left_over: np.ndarray = field(default_factory=lambda: np.full(6, np.nan))
    explained_share: float = 0.0
    small: tuple[Finding, ...] = ()
    determined: DeterminedModel | None = None

    @property
    def by_name(self) -> dict[str, Finding]:
        """The findings that have a name, by each name that they may bear; the largest goes first.

        Of small remainders too: what is told in one line is as well determined.
        """
        named = [one for one in (*self.findings, *self.small) if one.effect != UNNAMED]
        own = {one.effect: one for one in reversed(named)}
        return {name: one for one in reversed(named) for name in one.group} | own
