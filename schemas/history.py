"""What re-processing changed, and which runs used a measurement standard."""

from datetime import date, datetime
from typing import Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.calibration import Method
from schemas.certificate import State
from schemas.tolerance import Verdict

# of U: a certificate prints U with two digits and the value to the same place, which is 1 % of U or
# more, so that nothing printed moves by less; other processors move values by some 1e-11 U
COUNTED_IN_U = 0.01


class Change(Frozen):
    """An element whose value moved by more than COUNTED_IN_U, or its U by as much of itself, or k.

    Null: not determined.

    in_U: how far the value moved, over U before (U after, where there was none); null where it
    was or is not determined.
    """

    run: str
    method: str
    item: str
    element: str
    unit: str
    before: Finite | None
    after: Finite | None
    U_before: Finite | None
    U_after: Finite | None
    in_U: Finite | None
    k_before: Finite | None = None
    k_after: Finite | None = None


class Flip(Frozen):
    """A verdict that changed: on the run, on the unit, or on one element; or the reasons of that on
    the run. Those on the unit and on an element use the limits in the home; before is what the
    certificate says, where the run has one.
    """

    run: str
    method: str
    about: Literal["run", "unit", "element", "reasons"]
    item: str | None = None
    element: str | None = None
    before: str
    after: str


class Touched(Frozen):
    """A certificate that prints a result whose values changed; it is not altered."""

    number: str
    run: str
    state: State
    verdict: Verdict
    largest_in_U: Finite | None = Field(description="null where no value of it moved by a number")
    U_factor: Finite | None = Field(
        default=None, description="by which, above 1, a U of it is another one"
    )


class Failure(Frozen):
    """A result that could not be made again, and why, as a sentence."""

    run: str
    why: str


class Difference(Frozen):
    """What is different between two results of one run; of one with a certificate, from what that
    prints.
    """

    changed: tuple[Change, ...] = ()
    flips: tuple[Flip, ...] = ()


class Reprocessing(Frozen):
    """What re-processing a selection did and changed (format `mimu-reprocess/1`).

    done: results made again now or before under the same circumstances, which are the code and the
    laboratory. counted_in_U: the smallest change that counts, in U. unchanged: of them,
    results without any change; first: those of runs that had none
    before. seconds: of this command.
    """

    format: Literal["mimu-reprocess/1"] = "mimu-reprocess/1"
    code_version: str
    circumstances: str
    runs: int
    done: int
    done_before: int
    failed: int
    counted_in_U: Finite = COUNTED_IN_U
    unchanged: int
    first: int = 0
    changed: tuple[Change, ...] = ()
    flips: tuple[Flip, ...] = ()
    certificates: tuple[Touched, ...] = ()
    failures: tuple[Failure, ...] = ()
    seconds: float


class Plan(Frozen):
    """What re-processing a selection would do (format `mimu-reprocess-plan/1`)."""

    format: Literal["mimu-reprocess-plan/1"] = "mimu-reprocess-plan/1"
    code_version: str
    circumstances: str
    runs: tuple[str, ...] = Field(description="of which a result is still to be made")
    results: int = Field(description="to be made")
    done_before: int
    rows: int = Field(description="samples that are to be read")


class AffectedRun(Frozen):
    """A run that used a measurement standard, and which documents name it.

    documents: the manifest, or numbers of certificates; none for a run at the station of that name.
    """

    run: str
    recording_id: str
    unit: str
    station: str | None
    recorded_on: date | None
    documents: tuple[str, ...]


class AffectedResult(Frozen):
    """A result of such a run; newest: whether no other supersedes it."""

    result: str
    run: str
    method: Method
    newest: bool


class AffectedCertificate(Frozen):
    """A certificate that stands on such a run, as found or as left."""

    number: str
    run: str
    state: State
    verdict: Verdict
    issued_on: date
    due: date | None


class Impact(Frozen):
    """What used a measurement standard or a station in a time (format `mimu-impact/1`).

    undated: runs that used it, of which no day is known and which were imported at another time.
    """

    format: Literal["mimu-impact/1"] = "mimu-impact/1"
    equipment: str
    since: date | None
    until: date | None
    runs: tuple[AffectedRun, ...]
    results: tuple[AffectedResult, ...]
    certificates: tuple[AffectedCertificate, ...]
    undated: tuple[str, ...] = ()


class Dispensable(Frozen):
    """Data that nothing in the store needs. size: bytes of the files.

    A recording goes with its run; columns alone can be made again from the raw recording. A draft
    is a file left by an interrupted draft of a certificate: its run is unknown, and `imported_at`
    is when it was written.
    """

    what: Literal["recording", "columns", "draft"]
    run: str | None = None
    recording_id: str | None = None
    imported_at: datetime
    where: str
    size: int


class Refused(Frozen):
    """What was not deleted after all, and why, as a sentence."""

    what: Literal["recording", "columns", "draft"]
    run: str | None = None
    where: str
    why: str


class Pruned(Frozen):
    """What was imported before a day and is not needed (format `mimu-prune/1`).

    deleted: whether `found` was deleted, or would be; refused: what was not.
    """

    format: Literal["mimu-prune/1"] = "mimu-prune/1"
    before: date
    deleted: bool
    found: tuple[Dispensable, ...]
    refused: tuple[Refused, ...] = ()
