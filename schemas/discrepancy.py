"""Where model and recording differ: the result of `mimucal explain` (`mimu-discrepancy/1`)."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING, Any, Literal

from pydantic import AwareDatetime, Field

from schemas.base import Finite, Frozen
from schemas.text import Statement

if TYPE_CHECKING:
    import numpy as np  # the catalogue's lists start without it

Verdict = Literal["no_mismatch", "explained", "partly_explained", "unexplained"]
Dimension = Literal[
    "rate", "attitude", "rotation_phase", "frequency", "temperature", "time", "after_moves",
    "ramps", "recorded", "level",
]  # fmt: skip


class Where(Frozen):
    """Where a part of the excess lies. The shares of one finding add up to 1 over its entries."""

    channel: str
    dimension: Dimension
    description: Statement
    segments: tuple[str, ...]
    share: Finite


class FoundParameter(Frozen):
    """A parameter of the missing physics, in the unit named, with its standard uncertainty."""

    name: str
    value: Finite
    unit: str
    u: Finite


class EvidenceFor(Frozen):
    """delta_bic: what the model gained, Bayesian information criterion, positive is better.

    held_out_gain_nats: log-likelihood gained on segments that the fit did not see.
    """

    delta_bic: Finite
    held_out_gain_nats: Finite


class Consequence(Frozen):
    """How leaving the physics out changes one value of the certificate.

    U: of the value with the physics, its corrections' uncertainty included; U_before: what
    `calibrate` states for the value without, which a mismatch with the standard's model widens.
    """

    item: str
    element: str
    before: Finite | None
    after: Finite | None
    U: Finite | None
    unit: str
    U_before: Finite | None = None

    @property
    def change(self) -> float:
        """How far the element moves, with its sign; 0 where it has no value."""
        if self.before is None or self.after is None:
            return 0.0
        return self.after - self.before

    @property
    def in_U(self) -> float:
        """How many U the element moves, with its sign; 0 where it has no U.

        Relative to the larger U of the two: a change within the certificate's own U is not an error
        of the certificate, and a change within the correction's U is not significant.
        """
        U = max(self.U_before or 0.0, self.U or 0.0)
        return self.change / U if U else 0.0


class VerdictChange(Frozen):
    """A verdict against the tolerance that changes when the physics is taken into account."""

    item: str
    before: str
    after: str


class ReportedFinding(Frozen):
    """One piece of physics that the model left out.

    share: of the mismatch above noise that it removes. homogeneity_p: probability that its
    parameters agree between independent parts of the recording; null if no parts determine them.
    group: names of the catalogue that compensate for one another here, including this one; common:
    what they have in common. unlisted_form: it is the kind of physics that the name says, in a form
    that no publication lists. refused: why an unnamed finding does not get the name it resembles.
    jointly_with: numbers, from 1, of the findings that partly compensate for it: its consequences
    are theirs as well. next: what to do.
    """

    effect: str
    family: str
    title: Statement
    channels: tuple[str, ...]
    where: tuple[Where, ...]
    parameters: tuple[FoundParameter, ...]
    evidence: EvidenceFor
    share: Finite
    homogeneity_p: Finite | None
    group: tuple[str, ...] | None
    common: tuple[FoundParameter, ...] = ()
    unlisted_form: bool = False
    refused: Statement | None = None
    equation: str
    source: str
    follows: Statement | None = None
    indistinguishable_from: tuple[str, ...] = ()
    separating_recording: Statement | None = None
    consequences: tuple[Consequence, ...] = ()
    jointly_with: tuple[int, ...] = ()
    verdict_changes: tuple[VerdictChange, ...] = ()
    next: Statement
    statement: Statement


class Detection(Frozen):
    """p_value: of the strongest mismatch, corrected for how many were looked for."""

    p_value: Finite
    false_alarm_rate: Finite


class Moved(Frozen):
    """An element of a certificate that the physics changes, and by how many of its U."""

    item: str
    element: str
    in_U: Finite


class FindingInBrief(Frozen):
    """What the catalogue keeps of a finding beside its name. others: names that cannot be told
    apart from it.
    """

    title: Statement
    parameters: tuple[FoundParameter, ...]
    others: tuple[str, ...] = ()
    moved: tuple[Moved, ...] = ()


class HeldOut(Frozen):
    """How well segments that a fit did not use are predicted, before and after."""

    rms_ratio: Mapping[str, Finite]
    chi2_per_dof_before: Finite
    chi2_per_dof_after: Finite


class Discrepancy(Frozen):
    """The whole answer.

    digest: SHA-256 of the recording's content. model: what the recording is compared with.
    explained_share: of the mismatch above noise. left_over: χ² per degree of freedom of what is
    left in each channel, against the noise at rest. small_remainders: findings that remove too
    little of the mismatch to be reported in full. consequences, verdict_changes: of all findings
    together.
    """

    format: Literal["mimu-discrepancy/1"] = "mimu-discrepancy/1"
    recording_id: str
    digest: str = ""
    code_version: str = ""
    model: Statement
    verdict: Verdict
    detection: Detection
    explained_share: Finite
    left_over: Mapping[str, Finite]
    findings: tuple[ReportedFinding, ...] = ()
    small_remainders: tuple[Statement, ...] = ()
    consequences: tuple[Consequence, ...] = ()
    verdict_changes: tuple[VerdictChange, ...] = ()
    held_out: HeldOut
    figures: tuple[str, ...] = ()
    remarks: tuple[Statement, ...] = ()
    statement: Statement


# The recording that resolves what `explain` left open: the result of `mimucal next`.


class PredictedEvidence(Frozen):
    """What a recording is expected to show of the pair that is told apart worst.

    delta_chi2: by which the competing models differ. probability_right: of one name, the right one.
    """

    delta_chi2: Finite
    probability_right: Finite


class RepeatOfBase(Frozen):
    """What the same recording once more would show."""

    minutes: Finite
    delta_chi2: Finite


class NextRecording(Frozen):
    """decides: the competing effects; one alone against none. procedure: path of the file for
    `acquire --procedure`; null, without steps and minutes, where no recording of this station does.
    """

    format: Literal["mimu-next/1"] = "mimu-next/1"
    decides: tuple[str, ...]
    procedure: str | None
    minutes: Finite | None
    steps: tuple[dict[str, Any], ...]
    predicted: PredictedEvidence
    repeat_of_base: RepeatOfBase
    statement: Statement


# What many runs show together: the statistics of each run, and the result of `mimucal review`.


Level = Literal["unit", "lot", "station", "model", "site"]
LEVELS: tuple[Level, ...] = ("unit", "lot", "station", "model", "site")  # smallest first


class PooledParameter(Frozen):
    """A parameter of a term in SI; it is printed multiplied by `factor`, in `unit`.

    low, high: its plausible range. channels: 0 to 5, those it affects.
    """

    name: str
    unit: str
    factor: Finite
    low: Finite
    high: Finite
    channels: tuple[int, ...]


class PooledTerm(Frozen):
    """A term of the catalogue as it appears in the statistics of runs.

    at: values of its shapes. known: its one column is the whole effect, with factor one. rarity:
    chi-squared that it must gain beyond a more usual effect that looks the same.
    """

    name: str
    family: str
    at: tuple[Finite, ...]
    rarity: Finite
    known: bool
    parameters: tuple[PooledParameter, ...]


class Layout(Frozen):
    """The terms to which the parameters of a run's statistics belong, in order."""

    terms: tuple[PooledTerm, ...]

    @property
    def key(self) -> str:
        """SHA-256 of all that it says."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()


@dataclass(frozen=True)
class RunStatistics:
    """What one run says of the p parameters of the catalogue's terms, all else projected out.

    With c = 1/scale the whitened score of the parameters is right·c and their information is
    correlation·c·cᵀ, after the run's own standard parameters were fitted away.

    layout: what the parameters are; layout_key: its SHA-256. correlation: (p(p + 1)/2,) int16, the
    upper triangle of the Gram matrix of columns at unit size, in steps of 1/32767. right: (p,).
    scale: (p,) SI; zero where the run says nothing. left_over: (6,) chi-squared per degree of
    freedom that standard and catalogue together leave below 1 Hz, against which score and
    information are counted.
    """

    layout: Layout
    layout_key: str
    correlation: "np.ndarray"
    right: "np.ndarray"
    scale: "np.ndarray"
    left_over: "np.ndarray"


class Carrier(Frozen):
    """A site, station, model, lot or unit that carries an effect, and how much less likely it is
    than the best carrier.
    """

    level: Level
    carrier: str
    delta_bic: Finite


class Moment(Frozen):
    """The run from which, or up to which, an effect is present; `earliest` and `latest` hold 95 %.

    at, earliest, latest: ISO 8601, else the recording's name. without: the carrier's nearest run
    that certainly lacks the effect; the change itself lies between it and the runs of the 95 %.
    """

    run: str
    at: str
    earliest: str
    latest: str
    without: str = ""


class PooledValue(FoundParameter):
    """spread: standard deviation between the carrier's runs beyond their own uncertainty."""

    spread: Finite


class PooledEvidence(Frozen):
    """per_run_z_median: median size of the effect in one run, in its own standard deviations."""

    delta_bic: Finite
    per_run_z_median: Finite
    runs_that_show_it: int
    runs: int


class Touched(Frozen):
    """An element of a certificate that the effect changes, and by how many of its U."""

    certificate: str
    item: str
    element: str
    in_U: Finite


class ReviewFinding(Frozen):
    """An effect and its carrier."""

    effect: str
    level: Level
    carrier: str
    alternatives: tuple[Carrier, ...] = ()
    since: Moment | None = None
    until: Moment | None = None
    parameters: tuple[PooledValue, ...]
    evidence: PooledEvidence
    indistinguishable_from: tuple[str, ...] = ()
    touched: tuple[Touched, ...] = ()
    statement: Statement


class Skipped(Frozen):
    """A run that could not be used here."""

    run: str
    why: str


class EstimatedSite(Frozen):
    """Latitude and heading of a station that its manifests omit, estimated from Earth's rotation.

    latitude_expanded, heading_expanded: U, k = 2, degrees. Null if the runs do not determine it.
    """

    station: str
    runs: int
    latitude_deg: Finite | None
    latitude_expanded: Finite | None
    heading_deg: Finite | None
    heading_expanded: Finite | None
    statement: Statement


class Review(Frozen):
    """The complete result of a review."""

    format: Literal["mimu-review/1"] = "mimu-review/1"
    runs: int
    skipped: tuple[Skipped, ...] = ()
    code_version: str = ""
    verdict: Verdict
    detection: Detection
    findings: tuple[ReviewFinding, ...] = ()
    sites: tuple[EstimatedSite, ...] = ()
    figures: tuple[str, ...] = ()
    statement: Statement


class KeptReview(Frozen):
    """The last review of a home, when it was made, and of which runs.

    asked: the station, model, serial, since and until it was limited to, if any. days: first and
    last day of its runs; null if unknown.
    """

    format: Literal["mimu-kept-review/1"] = "mimu-kept-review/1"
    at: AwareDatetime
    asked: dict[str, str] = Field(default_factory=dict)
    days: tuple[date, date] | None = None
    review: Review
