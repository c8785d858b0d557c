"""What many runs show together: the statistics of each run, and the result of `mimucal review`."""

import hashlib
from dataclasses import dataclass
from datetime import date
from typing import Literal

import numpy as np
from pydantic import AwareDatetime, Field

from schemas.base import Finite, Frozen
from schemas.discrepancy import Detection, FoundParameter, Verdict
from schemas.text import Statement

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
    correlation: np.ndarray
    right: np.ndarray
    scale: np.ndarray
    left_over: np.ndarray


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
