"""Stated intervals and values against the truth of simulated units: coverage, and recovery.

Coverage: over many units, how often the stated 95 % interval holds the truth. Recovery: what an
ideal run without noise says of a unit.
"""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from decimal import Decimal
from multiprocessing import get_context
from typing import TypeVar

import numpy as np
import pandas as pd

from schemas.calibration import TARGET_SHARE, Calibration, Check, Coverage, Item
from schemas.recording import Recording
from tasks.quality import wilson
from tasks.uncertainty.monte_carlo import combine_as_example
from tasks.validation import run1536, run2003
from tasks.validation.record import G_SENSITIVITY, WITHOUT_EARTH, checked, clause_item
from tasks.validation.simulated_units import SimulatedUnit, draw_simulated_unit
from tasks.words import message
from tasks.words.numbers import round_up

Job = TypeVar("Job")
Done = TypeVar("Done")
Calibrate = Callable[..., Calibration]
Truth = dict[str, dict[str, float]]
Run = Callable[[SimulatedUnit, int], tuple[Recording, Truth]]

NORMAL_95 = 1.959964  # half the 95 % interval of a normal distribution, in u
MIN_UNITS = 2000
MAX_ERROR = 1e-9  # of a recovered value, in the printed unit of the item
RUNS: dict[str, tuple[Run, float]] = {
    "jjf2003": (run2003.record, run2003.RATE_HZ),
    "joint": (run2003.record, run2003.RATE_HZ),
    "jjf1536": (run1536.record, run1536.RATE_HZ),
}
# Of each element of each item: error, u, half the 95 % interval, U.
Errors = dict[str, dict[str, tuple[float, float, float, float]]]


def simulate(method: str, seed: int, ideal: bool = False) -> tuple[Recording, Truth]:
    """A recording for a method of the unit with this seed, and the truth of its items."""
    record, rate_hz = RUNS[method]
    recording, truth = record(draw_simulated_unit(seed, rate_hz, ideal), seed)
    return recording, truth_by(method, truth)


def truth_by(method: str, truth: Truth) -> Truth:
    """What a method should find: the joint method's g-sensitivity is without Earth's rotation."""
    return {**truth, G_SENSITIVITY: truth[WITHOUT_EARTH]} if method == "joint" else truth


def errors_of(calibration: Calibration, truth: Truth) -> Errors:
    """Errors and stated uncertainties of every element whose truth is known."""
    errors: Errors = {}
    for name, item in calibration.items.items():
        errors[name] = {
            element: (value - truth[name][element], u, _half_width(item, element, u), U)
            for element, value in item.value.items()
            if name in truth and value is not None
            and (u := item.u[element]) is not None and (U := item.U[element]) is not None
        }  # fmt: skip
        values, us = item.value_without_earth_rotation, item.u_without_earth_rotation
        if calibration.method != "joint" and values and us and name == G_SENSITIVITY:
            errors[WITHOUT_EARTH] = {
                element: (value - truth[WITHOUT_EARTH][element], u, NORMAL_95 * u, item.k * u)
                for element, value in values.items()
                if value is not None and (u := us[element]) is not None
            }
    return {name: elements for name, elements in errors.items() if elements}


def _half_width(item: Item, element: str, u: float) -> float:
    budget = item.budgets.get(element)
    stated = budget.half_width_95 if budget else None
    return NORMAL_95 * u if stated is None else stated


def errors_of_unit(job: tuple[str, Calibrate, int]) -> tuple[str, Errors]:
    """One unit simulated and calibrated; for a process of its own."""
    method, calibrate, seed = job
    recording, truth = simulate(method, seed)
    return method, errors_of(calibrate(recording, run="simulated", code_version="-"), truth)


def study(
    methods: dict[str, Calibrate], units: int, seed: int, report: Callable[[int, int], None]
) -> dict[str, dict[str, Coverage]]:
    """Coverage of every item by each method over as many units, in a process for each core."""
    jobs = [(m, methods[m], seed + i) for i in range(units) for m in methods]
    errors_of_methods: dict[str, list[Errors]] = {method: [] for method in methods}
    for done, (method, errors) in enumerate(in_processes(errors_of_unit, jobs), start=1):
        errors_of_methods[method].append(errors)
        report(done, len(jobs))
    return {method: summarise(errors) for method, errors in errors_of_methods.items()}


def in_processes(do: Callable[[Job], Done], jobs: list[Job]) -> Iterator[Done]:
    """The jobs' results as they come; one thread each, or the processes hinder one another."""
    threads = ("OPENBLAS_NUM_THREADS", "1")  # read when a process imports numpy, at its first job
    with ProcessPoolExecutor(
        mp_context=get_context("spawn"), initializer=os.putenv, initargs=threads
    ) as pool:
        yield from pool.map(do, jobs, chunksize=max(1, min(8, len(jobs) // 8)))


def summarise(runs: Iterable[Errors]) -> dict[str, Coverage]:
    """Coverage of each item, pooled over its elements and over the runs."""
    rows = [
        (item, run, element, *row)
        for run, errors in enumerate(runs)
        for item, elements in errors.items()
        for element, row in elements.items()
    ]
    table = pd.DataFrame(rows, columns=["item", "run", "element", "error", "u", "half_95", "U"])
    return {str(item): _coverage(rows) for item, rows in table.groupby("item", sort=False)}


def _coverage(rows: pd.DataFrame) -> Coverage:
    units, size = rows["run"].nunique(), rows["error"].abs()
    inside = size <= rows["half_95"]
    share = float(inside.mean())
    return Coverage(
        units=units,
        elements=len(rows),
        inside_95=share,
        confidence=interval_of_share(share, units),
        inside_expanded=float((size <= rows["U"]).mean()),
        rms_z=float(np.sqrt(((size / rows["u"]) ** 2).mean())),
        by_element={
            str(element): float(each.mean())
            for element, each in inside.groupby(rows["element"], sort=False)
        },
    )


def interval_of_share(share: float, count: int) -> tuple[float, float]:
    """The 95 % interval (Wilson) of a probability that showed itself as a share of a count.

    The elements of one unit share its table's errors, so the count is that of the units, of which
    the share need not be a whole number.
    """
    low, high = wilson(np.array(share * count), np.array(count))
    return float(low), float(high)


def coverage_check(coverage: Coverage) -> Check:
    """Whether an item's intervals hold the truth as often as they say, over enough units.

    Intervals that hold it more often are longer than they need be, which is said here; the gate
    asks each element (`Coverage.too_short`).
    """
    low, high = (f"{100 * share:.0f}" for share in TARGET_SHARE)
    long = ".too-long" if coverage.inside_95 > TARGET_SHARE[1] else ""
    return checked(
        coverage.units >= MIN_UNITS and coverage.inside_95 >= TARGET_SHARE[0],
        message(
            f"validation-coverage{long}", share=f"{100 * coverage.inside_95:.1f} %",
            values=coverage.elements, units=coverage.units, low=low, high=high,
            fewest=MIN_UNITS,
        ),
    )  # fmt: skip


def recovery_checks(method: str, calibrate: Calibrate, seed: int) -> dict[str, Check]:
    """Largest error of each item in an ideal run: no noise, no errors of the equipment."""
    recording, truth = simulate(method, seed, ideal=True)
    calibration = calibrate(recording, run="ideal", code_version="-")
    checks = {}
    for name, elements in errors_of(calibration, truth).items():
        largest = max(abs(error) for error, *_ in elements.values())
        unit = calibration.items[clause_item(name)].unit
        stated = message(
            "validation-recovery", error=f"{largest:.1e}", unit=unit, close=f"{MAX_ERROR:.0e}"
        )
        checks[name] = checked(largest <= MAX_ERROR, stated)
    return checks


# The worked examples of both Appendices A, computed by the code that prints them.

# The example's title, what is added up to u₃, and u_c and U as printed.
SCALE = ("A.1", (1.22e-4,), "2.12e-4", "4.3e-4")
BIAS = ("A.2", (3.41e-5,) * 6, "2.68e-4", "5.36e-4")
PAIR = ("A.3", (2.51e-3,) * 2, "5.02e-3", "1.1e-2")
ZERO = ("A.2", (3.41e-5,) * 4, "2.20e-4", "4.4e-4")
EXAMPLES = {
    "gyro_scale_factor": SCALE,
    "gyro_cross_coupling": SCALE,
    "gyro_fit_offset": SCALE,  # of the same straight line
    "gyro_bias": BIAS,
    "gyro_g_sensitivity": PAIR,
    "accel_scale_factor": SCALE,
    "accel_cross_coupling": SCALE,
    "accel_bias": BIAS,
    "accel_rate_sensitivity": PAIR,
    "ahrs_scale_factor": SCALE,
    "ahrs_zero_offset": ZERO,
    "ahrs_misalignment": PAIR,
}
DIGITS = 3


def example_check(item: str) -> Check:
    """Whether the example that an item's uncertainty follows comes out to its printed digits."""
    clause, components, u_c, U = EXAMPLES[item]
    specification = "JJF 1536-2015" if item.startswith("ahrs") else "JJF 2003-2022"
    budget = combine_as_example(item, "1", 0.0, components)
    printed = Decimal(repr(budget.U)) if len(U.split("e")[0]) > DIGITS else round_up(budget.U)
    passed = Decimal(repr(budget.u_c)) == Decimal(u_c) and printed == Decimal(U)
    return checked(
        passed,
        message(
            "validation-example", specification=specification, clause=clause, u_c=u_c, U=U,
            result=f"u_c = {budget.u_c:.2e}, U = {printed:.2e}",
        ),
    )  # fmt: skip
