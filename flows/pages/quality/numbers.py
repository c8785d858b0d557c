"""The numbers of each table and chart of the Quality page, as rows."""

from collections.abc import Sequence
from typing import Any

from flows.pages.numbers import Numbers, Row, rows_of
from flows.pages.quality.models import QualityShown
from tasks.quality.charts import RULES


def _of_element(shown: QualityShown) -> dict[str, Any]:
    return {"model": shown.model, "item": shown.item, "element": shown.element, "unit": shown.unit}


def _total(shown: QualityShown) -> Sequence[Row]:
    return rows_of([each for each in (shown.total, *shown.by_item) if each], model=shown.model)


def _capability(shown: QualityShown) -> Sequence[Row]:
    found = [shown.capability] if shown.capability else []
    return rows_of(found, **_of_element(shown))


def _chart(shown: QualityShown) -> Sequence[Row]:
    if shown.chart is None:
        return []
    limits = {name: getattr(shown.chart, name)
              for name in ("plotted", "centre", "lower", "upper", "range_limit")}  # fmt: skip
    return rows_of(shown.chart.points, **_of_element(shown), **limits)


def _rules(shown: QualityShown) -> Sequence[Row]:
    points = shown.chart.points if shown.chart else ()
    return [
        {**_of_element(shown), "rule": rule, "count": sum(rule in each.broken for each in points)}
        for rule in range(1, RULES + 1)
    ]


def _golden(shown: QualityShown) -> Sequence[Row]:
    return [
        row
        for of in shown.golden
        for row in rows_of(of.points, **_of_element(shown),
                           **of.model_dump(mode="json", exclude={"points"}))
    ]  # fmt: skip


NUMBERS: Numbers = {
    "by_period": lambda shown: rows_of(shown.by_period, model=shown.model),
    "by_item": _total,
    "by_station": lambda shown: rows_of(shown.by_station, model=shown.model),
    "by_model": lambda shown: rows_of(shown.by_model),
    "failing": lambda shown: rows_of(shown.failing, model=shown.model),
    "capability": _capability,
    "chart": _chart,
    "rules": _rules,
    "golden": _golden,
    "stations": lambda shown: rows_of(shown.stations, **_of_element(shown)),
}
