"""Where model and recording differ: the result of `mimucal explain` (`mimu-discrepancy/1`)."""

from collections.abc import Mapping
from typing import Any, Literal

from schemas.base import Finite, Frozen
from schemas.text import Statement

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
        """By how much it moves, with its sign; 0 where it has no value."""
        if self.before is None or self.after is None:
            return 0.0
        return self.after - self.before

    @property
    def in_U(self) -> float:
        """By how many U it moves, with its sign; 0 where it has no U.

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
