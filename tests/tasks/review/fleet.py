"""Fleets of statistics without recordings: columns of chance, and what carries an effect."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from schemas.discrepancy import Layout, PooledParameter, PooledTerm, RunStatistics
from tasks.review.pool import STEP, Pool, ReviewedRun, pooled

NAMES = ("axis_tilt", "lever_arm", "size_effect", "gyro_g2_sensitivity", "table_scale")
SIZES = (2, 3, 3, 3, 1)
ROWS = 60


def layout() -> Layout:
    """Five terms of a few parameters."""
    return Layout(
        terms=tuple(
            PooledTerm(
                name=name, family="f", at=(), rarity=0.0, known=False,
                parameters=tuple(
                    PooledParameter(
                        name=f"p{q}", unit="1", factor=1.0, low=-100.0, high=100.0, channels=(0, 1)
                    )
                    for q in range(size)
                ),
            )
            for name, size in zip(NAMES, SIZES, strict=True)
        )
    )  # fmt: skip


def place(name: str) -> slice:
    """Where a term's parameters stand."""
    k = NAMES.index(name)
    return slice(sum(SIZES[:k]), sum(SIZES[: k + 1]))


def statistics(rng: np.random.Generator, columns: np.ndarray, values: np.ndarray) -> RunStatistics:
    """Of one run with white noise of one; columns (rows, p), values (p,)."""
    readings = columns @ values + rng.standard_normal(len(columns))
    gram = columns.T @ columns
    size = np.sqrt(np.diag(gram))
    correlation = gram / size[:, None] / size
    triangle = correlation[np.triu_indices(len(size))]
    return RunStatistics(
        LAYOUT, KEY, np.round(triangle * STEP).astype(np.int16),
        (columns.T @ readings / size).astype(np.float32), (1.0 / size).astype(np.float32),
        np.ones(6, np.float32),
    )  # fmt: skip


Values = Callable[[int, int, int], np.ndarray]  # unit, station, day -> (p,)


def fleet(
    seed: int, values: Values, *, runs: int = 80, units: int = 12, stations: int = 4,
    station_of: Callable[[int], int] | None = None, same_name: tuple[str, ...] = (),
    alike: tuple[str, str] | None = None,
) -> Pool:  # fmt: skip
    """Runs day after day of units that go from station to station, or stay on their own.

    same_name: terms that are forms of the first one. alike: two terms that differ by a twentieth.
    """
    rng = np.random.default_rng(seed)
    shared = rng.standard_normal((ROWS, sum(SIZES))) / np.sqrt(ROWS)
    found = []
    for day in range(runs):
        unit = int(rng.integers(units))
        station = station_of(unit) if station_of else int(rng.integers(stations))
        columns = shared + 0.2 * rng.standard_normal(shared.shape) / np.sqrt(ROWS)
        if alike is not None:
            one, other = map(place, alike)
            columns[:, other] = columns[:, one] + 0.05 * columns[:, other]
        carriers = {
            "unit": f"U{unit}", "station": f"S{station}", "model": f"M{unit % 2}", "site": "here"
        }  # fmt: skip
        run = ReviewedRun(f"r{day:03d}", f"2026-01-01T{day:05d}", carriers)
        made = statistics(rng, columns, values(unit, station, day))
        if same_name:
            made = replace(made, layout=as_forms(same_name))
        found.append((run, made))
    return pooled(found)


def as_forms(names: tuple[str, ...]) -> Layout:
    """The layout with some terms as forms of the first of them."""
    terms = (
        term.model_copy(update={"name": names[0], "at": (float(names.index(term.name)),)})
        if term.name in names
        else term
        for term in LAYOUT.terms
    )
    return Layout(terms=tuple(terms))


def of(name: str, size: float) -> np.ndarray:
    """(p,) values: an effect with each parameter of a size."""
    values = np.zeros(sum(SIZES))
    values[place(name)] = size
    return values


NOTHING = np.zeros(sum(SIZES))
LAYOUT = layout()
KEY = LAYOUT.key
