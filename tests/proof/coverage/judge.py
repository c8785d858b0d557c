"""`python -m tests.proof.coverage.judge UNITS SEED [SCENARIO …]`: stated U against the bench."""

import sys
from collections import Counter, defaultdict

import numpy as np

from schemas.calibration import Calibration, Method
from schemas.recording import Manifest, Recording, Stream
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.specifications.register import SPECIFICATIONS
from tests.proof.coverage.bench import SCENARIOS, record

GOOD, R = 0.93, (0.8, 1.15)
METHODS: tuple[Method, ...] = ("jjf2003", "joint")


def recording_of(manifest: dict, streams: dict) -> Recording:
    made = {name: Stream(t, columns) for name, (t, columns) in streams.items()}
    return Recording(
        Manifest.model_validate(manifest), made["imu"], table=made.get("table"),
        environment=made["environment"], digest="0" * 64,
    )  # fmt: skip


def errors(made: Calibration, truth: dict) -> dict[str, list[tuple[float, float | None]]]:
    """By item: (error, U) of each determined element; zeros of the mean over the run besides."""
    found = defaultdict(list)
    joint = made.method == "joint"
    for key, item in made.items.items():
        true = truth["gyro_g_sensitivity_without" if joint and key == "gyro_g_sensitivity" else key]
        for e, value in item.value.items():
            if value is None:
                continue
            found[key].append((value - true[e], item.U[e]))
            if item.temperature_degc and key in truth["per K"]:
                warmer = item.temperature_degc[e] - truth["per K"]["at"]
                there = true[e] + truth["per K"][key][e] * warmer
                found[f"{key} (its °C)"].append((value - there, item.U[e]))
            if e in truth["mean over the run"].get(key, {}):
                extra = truth["mean over the run"][key][e]
                found[f"{key} (run)"].append((value - true[e] - extra, item.U[e]))
        if not joint and item.value_without_earth_rotation and item.U_without_earth_rotation:
            for e, value in item.value_without_earth_rotation.items():
                if value is not None:
                    error = value - truth["gyro_g_sensitivity_without"][e]
                    found[f"{key} (free)"].append((error, item.U_without_earth_rotation[e]))
    return found


def main(units: int, seed: int, names: list[str]) -> None:
    for name in names or list(SCENARIOS):
        for method in METHODS:
            pooled: dict[str, list[tuple[float, float | None]]] = defaultdict(list)
            codes: Counter[str] = Counter()
            invalid = 0
            for i in range(units):
                manifest, streams, truth = record(SCENARIOS[name], seed + i)
                recording = recording_of(manifest, streams)
                made = calibrate(
                    SPECIFICATIONS[method], recording, run="bench", code_version="-",
                    evaluation=evaluation_for(recording),
                )  # fmt: skip
                for key, rows in errors(made, truth).items():
                    pooled[key] += rows
                codes.update({one.code for one in made.remarks})
                invalid += any(one.run == "invalid" for one in made.remarks)
            print(f"\n## {name} · {method} · {units} units · invalid {invalid}")
            print("  " + ", ".join(f"{code} {count}" for code, count in sorted(codes.items())))
            for key, rows in pooled.items():
                with_u = np.array([(e, u) for e, u in rows if u is not None]).reshape(-1, 2)
                if not len(with_u):
                    print(f"  {key:32s} no U ({len(rows)})")
                    continue
                z = np.abs(with_u[:, 0]) / with_u[:, 1]
                good = np.mean(z <= 1) >= GOOD and R[0] <= 2 * np.sqrt(np.mean(z**2)) <= R[1]
                print(
                    f"{' ' if good else '!'} {key:32s} {100 * np.mean(z <= 1):5.1f} % "
                    f"of {len(z):4d}  "
                    f"r {2 * np.sqrt(np.mean(z**2)):6.2f}  max {z.max():7.2f}  "
                    f"U {np.median(with_u[:, 1]):.2g}",
                    flush=True,
                )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])
