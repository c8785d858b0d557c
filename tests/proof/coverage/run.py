"""How often stated U holds the truth, on recordings that share no code with the program."""

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer

from schemas.calibration import Calibration, Method
from schemas.recording import Manifest, Recording, Stream
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.specifications.register import SPECIFICATIONS
from tasks.version import code_version
from tests.proof.coverage import ahrs, bench
from tests.proof.study import Count, Minutes, Out, Seed, Write, hold, table

GOOD, R = 0.93, (0.8, 1.15)  # least share within U, and rms of error/(U/2)
USUAL = frozenset({
    "environment_not_recorded", "unit_temperature_not_recorded", "supply_not_recorded",
    "slow_sampling",
})  # fmt: skip
Errors = dict[str, list[tuple[float, float | None]]]  # error and U of each element, by item
SCENARIOS: Mapping[str, tuple[Callable[[int], bench.Made], tuple[Method, ...]]] = {
    **{
        name: (partial(bench.record, each), ("jjf2003", "joint"))
        for name, each in bench.SCENARIOS.items()
    },
    **{
        f"AHRS: {name}": (partial(ahrs.record, each), ("jjf1536",))
        for name, each in ahrs.SCENARIOS.items()
    },
}


@dataclass(frozen=True)
class Answered:
    """One recording by one method. codes: of its remarks."""

    scenario: str
    method: Method
    errors: Errors
    codes: frozenset[str]
    is_invalid: bool


def coverage(
    count: Count = 20, seed: Seed = 1,
    only: Annotated[
        str, typer.Option(metavar="NAME", help="Scenarios whose name begins so.")
    ] = "",
    out: Out = None, minutes: Minutes = None, write: Write = False,
) -> None:  # fmt: skip
    """Stated U against the truth of N units in each scenario of a laboratory."""
    names = [name for name in SCENARIOS if name.startswith(only)]
    work = {
        f"{list(SCENARIOS).index(name):02d}-{unit}": (name, unit)
        for unit in range(seed, seed + count)
        for name in names
    }
    hold("coverage", work, _answered, _page, out, minutes=minutes, write=write)


def _answered(work: tuple[str, int]) -> list[Answered]:
    """A unit of a scenario, by each method."""
    name, unit = work
    record, methods = SCENARIOS[name]
    manifest, streams, truth = record(unit)
    recording = recording_of(manifest, streams)
    found = []
    for method in methods:
        made = calibrate(
            SPECIFICATIONS[method], recording, run="bench", code_version="-",
            evaluation=evaluation_for(recording),
        )  # fmt: skip
        codes = frozenset(one.code for one in made.remarks)
        invalid = any(one.run == "invalid" for one in made.remarks)
        found.append(Answered(name, method, errors(made, truth), codes, invalid))
    return found


def recording_of(manifest: dict[str, Any], streams: dict[str, Any]) -> Recording:
    made = {name: Stream(t, columns) for name, (t, columns) in streams.items()}
    return Recording(
        Manifest.model_validate(manifest), made["imu"], table=made.get("table"),
        environment=made.get("environment"), digest="0" * 64,
    )  # fmt: skip


def errors(made: Calibration, truth: Mapping[str, Any]) -> Errors:
    """Of each determined element; of zeros against their mean over the run, too, of what follows
    the temperature at its own, and in JJF 2003 of g-sensitivity without Earth's rotation.
    """
    found: Errors = defaultdict(list)
    joint = made.method == "joint"
    for key, item in made.items.items():
        if key not in truth:
            continue
        true = truth["gyro_g_sensitivity_without" if joint and key == "gyro_g_sensitivity" else key]
        per_k, over_run = truth.get("per K", {}), truth.get("mean over the run", {}).get(key, {})
        for e, value in item.value.items():
            if value is None:
                continue
            found[key].append((value - true[e], item.U[e]))
            if item.temperature_degc and key in per_k:
                there = true[e] + per_k[key][e] * (item.temperature_degc[e] - per_k["at"])
                found[f"{key} (its °C)"].append((value - there, item.U[e]))
            if e in over_run:
                found[f"{key} (run)"].append((value - true[e] - over_run[e], item.U[e]))
        if not joint and item.value_without_earth_rotation and item.U_without_earth_rotation:
            free = truth["gyro_g_sensitivity_without"]
            found[f"{key} (free)"] += [
                (value - free[e], item.U_without_earth_rotation[e])
                for e, value in item.value_without_earth_rotation.items()
                if value is not None
            ]
    return dict(found)


def _page(found: Sequence[list[Answered]]) -> str:
    every = [one for both in found for one in both]
    runs, rows = [], []
    for name, method in dict.fromkeys((one.scenario, one.method) for one in every):
        some = [one for one in every if (one.scenario, one.method) == (name, method)]
        codes = Counter(code for one in some for code in one.codes - USUAL)
        listed = ", ".join(f"{code} {count}" for code, count in sorted(codes.items()))
        runs.append((name, method, len(some), sum(one.is_invalid for one in some), listed))
        for item in dict.fromkeys(key for one in some for key in one.errors):
            pairs = [pair for one in some for pair in one.errors.get(item, ())]
            rows.append((name, method, item, *_figures(pairs)))
    return "\n".join([
        "# Coverage of stated U", "",
        f"mimucal {code_version()}. Share of the true values within U, and r, the rms of "
        f"error/(U/2); ! beside what is below {100 * GOOD:.0f} %, or r outside {R[0]:g} to {R[1]:g}"
        ". (run): against the mean over the run; (its °C): at the element's own temperature; "
        "(free): without Earth's rotation.", "",
        *table(("scenario", "method", "units", "invalid", "remarks"), runs), "",
        *table(("scenario", "method", "item", "", "within U", "of", "r", "most, U", "U, median"),
               rows), "",
    ])  # fmt: skip


def _figures(pairs: Sequence[tuple[float, float | None]]) -> tuple[object, ...]:
    stated = np.array([(error, U) for error, U in pairs if U is not None]).reshape(-1, 2)
    if not len(stated):
        return "", "no U", f"0 of {len(pairs)}", "", "", ""
    z = np.abs(stated[:, 0]) / stated[:, 1]
    inside, r = float(np.mean(z <= 1.0)), float(2.0 * np.sqrt(np.mean(z**2)))
    good = inside >= GOOD and R[0] <= r <= R[1]
    return (
        "" if good else "!", f"{100.0 * inside:.1f} %", f"{len(z)} of {len(pairs)}", f"{r:.2f}",
        f"{z.max():.2f}", f"{np.median(stated[:, 1]):.2g}",
    )  # fmt: skip
