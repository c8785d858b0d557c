"""The signals of a run, reduced to as many points as a screen can show."""

from pydantic import Field

from schemas.base import Finite, Frozen


class SignalsQuestion(Frozen):
    """A channel of a stream between two times (s); null: from the beginning, to the end.

    bins: into how many equal times it is divided where it has more than twice as many rows.
    """

    run: str = Field(min_length=1, max_length=200)
    stream: str = "imu"
    channel: str = "gyro_x"
    since: Finite | None = None
    until: Finite | None = None
    bins: int = Field(default=1000, ge=1, le=10_000)


class SignalsShown(Frozen):
    """Every row, or of each bin the smallest and largest value: no peak is lost.

    t: s, of the row or of the beginning of the bin; low, high: the same where every row is shown
    (`is_reduced` is false), null where a bin has no number. rows: how many are between the times.
    unit: of the channel. channels: those of each stream of the run.
    """

    run: str
    stream: str
    channel: str
    unit: str
    since: Finite
    until: Finite
    rows: int
    is_reduced: bool
    t: tuple[Finite, ...]
    low: tuple[Finite | None, ...]
    high: tuple[Finite | None, ...]
    channels: dict[str, tuple[str, ...]]
