"""Statistics over many runs: yield, capability, control chart, station against station."""

from datetime import date
from typing import Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.text import Statement
from tasks.quality.capability import CapabilityIndex

Plotted = Literal["value", "change"]
Cause = Literal["adjusted", "station", "equipment"]
Name = Field(default=None, max_length=200)


class QualityQuestion(Frozen):
    """Of which runs, and of which element. Null: all of them; of model and element: the first one.

    plot: what the control chart shows, values or their changes since the unit's run before.
    """

    model: str | None = Name
    item: str | None = Name
    element: str | None = Name
    station: str | None = Name
    serial: str | None = Name
    since: date | None = None
    until: date | None = None
    plot: Plotted = "value"


class ItemChoice(Frozen):
    """An item with its elements, as the newest result of the model has them."""

    item: str
    title: Statement
    unit: str
    elements: tuple[str, ...]


class Choices(Frozen):
    """What may be asked for. serials: of the model that is chosen."""

    models: tuple[str, ...]
    items: tuple[ItemChoice, ...]
    stations: tuple[str, ...]
    serials: tuple[str, ...]


class Yield(Frozen):
    """How many of how many first runs passed, with the 95 % interval of their share."""

    name: str
    passed: int
    of: int
    share: Finite
    low: Finite
    high: Finite


class PeriodYield(Yield):
    """The yield of adjacent weeks, from a Monday to a Sunday."""

    since: date
    until: date


class Failing(Frozen):
    """How often the first runs of the selection fail a limit. item null: how many are not passed
    for the reason in the title: invalid, or what keeps a certificate from deciding.

    failed, inconclusive: limits of the element, each on one run. cumulative: the share of all that
    did not pass, up to this one.
    """

    item: str | None
    element: str
    title: Statement
    symbol: str
    failed: int
    inconclusive: int
    cumulative: Finite


class Counted(Frozen):
    """The runs of the selection. golden: of golden units, which count no further. retests: not
    counted in any yield. first: the others; undecided: of these the valid ones without a
    certificate or draft, which are not counted either. passed, failed, inconclusive (or passed, but
    for elements that are missing): the valid ones that are counted.
    """

    runs: int
    golden: int
    retests: int
    first: int
    undecided: int
    invalid: int
    passed: int = 0
    failed: int = 0
    inconclusive: int = 0


class CapabilityShown(Frozen):
    """Of the values of valid first runs. mean, within, overall: in the element's unit.

    lower, upper: the limits of the newest certificate; limits_vary: whether others printed others.
    margin_median, margin_95: share of the margin to the nearer limit that U takes, of half and of
    95 % of the values at most; null where it is infinite. over: values less than U within a limit,
    or outside of it.
    """

    n: int
    lower: Finite | None
    upper: Finite | None
    limits_vary: bool
    mean: Finite | None
    within: Finite | None
    overall: Finite | None
    cp: CapabilityIndex
    cpk: CapabilityIndex
    pp: CapabilityIndex
    ppk: CapabilityIndex
    margin_median: Finite | None
    margin_95: Finite | None
    over: int


class Plot(Frozen):
    """A run on the control chart. broken: the rules of Nelson that it breaks, 1 to 8."""

    run: str
    day: date
    serial: str
    station: str
    value: Finite
    range: Finite | None
    broken: tuple[int, ...] = ()


class Event(Frozen):
    """What may have caused a change: of a unit at a run, or of the station's equipment."""

    day: date
    cause: Cause
    name: str


class ChartShown(Frozen):
    """Individual values and moving ranges in the order of time. lower, upper: three sigma."""

    plotted: Plotted
    centre: Finite
    sigma: Finite
    lower: Finite
    upper: Finite
    mean_range: Finite
    range_limit: Finite
    points: tuple[Plot, ...]
    events: tuple[Event, ...] = ()


class GoldenPoint(Frozen):
    """A run of a golden unit. broken: the rules of Nelson that it breaks, 1 to 8."""

    run: str
    day: date
    value: Finite
    broken: tuple[int, ...] = ()


class GoldenShown(Frozen):
    """What a station read of a golden unit, in the order of time.

    centre, lower, upper: of the first `history` values, three sigma; null where there are too few.
    """

    station: str
    serial: str
    history: int
    centre: Finite | None
    lower: Finite | None
    upper: Finite | None
    points: tuple[GoldenPoint, ...]


class StationShown(Frozen):
    """What a station reads beside the mean of all, by units that were run on several. U: k = 2."""

    station: str
    difference: Finite | None
    U: Finite | None
    runs: int


class QualityShown(Frozen):
    """The quality of a selection. item, element: of capability, chart and stations; null where no
    run has a result. Yields by model are those of all models at the station and in the time.
    by_period: adjacent weeks, so many together that a point says something. failing: the most
    frequent first.
    """

    choices: Choices
    model: str | None
    item: str | None
    element: str | None
    title: Statement | None
    symbol: str
    unit: str
    retest_days: int
    counted: Counted
    total: Yield | None
    by_item: tuple[Yield, ...]
    by_model: tuple[Yield, ...]
    by_station: tuple[Yield, ...]
    by_week: tuple[Yield, ...]
    by_period: tuple[PeriodYield, ...]
    failing: tuple[Failing, ...]
    capability: CapabilityShown | None
    chart: ChartShown | None
    golden: tuple[GoldenShown, ...]
    stations: tuple[StationShown, ...]
