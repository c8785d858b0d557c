"""What imucal and allantools do as well, by them and by this program."""

import warnings
from functools import partial

import allantools
import numpy as np
from imucal import FerrarisCalibration, FerrarisSignalRegions

from schemas.recording import ACCEL, AXES, GYRO, Recording, Stream
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.information.noise import allan_curve
from tasks.specifications.jjf2003 import JJF2003
from tests.bench.measure import Figure, Section, processor_s
from tests.bench.recordings import GRAVITY, NOISE, RATE_HZ
from tests.manifests import manifest_of

DWELL = 20_000  # rows


def ferraris() -> Section:
    """Six rests and three turns: scale factors, cross coupling and biases."""
    rng = np.random.default_rng(5)
    parts, segments, rows = {}, [], []
    turns = [(f"{axis}_rot", axis, 1.0) for axis in AXES]
    rests = [(f"{axis}_{kind}", axis, s) for axis in AXES for kind, s in (("p", 1.0), ("a", -1.0))]
    for number, (name, axis, sign) in enumerate([*rests, *turns]):
        one = np.eye(3)[AXES.index(axis)]
        turning = 360.0 * RATE_HZ / DWELL if name.endswith("_rot") else 0.0
        level = np.concatenate([np.radians(turning) * one, sign * GRAVITY * one])
        rows.append(level + rng.normal(0.0, NOISE, (DWELL, 6)))
        parts[f"acc_{name}"] = rows[-1][:, 3:]
        parts[f"gyr_{name}"] = np.degrees(rows[-1][:, :3])
        length = DWELL / RATE_HZ
        what = {"kind": "rotation", "axis": axis, "angle_deg": 360.0} if turning else {
            "kind": "static", "up": ("+" if sign > 0 else "-") + axis
        }  # fmt: skip
        start = number * length
        segments.append({"name": name, "t_start": start, "t_end": start + length, **what})
    manifest = manifest_of("ferraris", {"gravity_m_s2": GRAVITY}, segments=segments)
    values = np.concatenate(rows)
    columns_of = dict(zip(GYRO + ACCEL, values.T.copy(), strict=True))
    made = Recording(manifest, Stream(np.round(np.arange(len(values)) / RATE_HZ, 9), columns_of))
    theirs = partial(
        FerrarisCalibration(expected_angle=360).compute, FerrarisSignalRegions(**parts), RATE_HZ,
        from_acc_unit="m/s^2", from_gyr_unit="deg/s",
    )  # fmt: skip
    ours = partial(calibrate, JJF2003, made, run="bench", code_version="bench")
    figures = (
        Figure("imucal: matrices and biases", processor_s(theirs)),
        Figure("`calibrate`: the same with budgets, validity, noise", processor_s(ours)),
    )
    return Section(f"A Ferraris session of {len(values):,} rows", figures)


def allan() -> Section:
    """Overlapping Allan deviations of three channels at the same averaging times."""
    readings = np.random.default_rng(3).normal(size=(3, 500_000))
    taus = allan_curve([readings], 1.0 / RATE_HZ).tau

    def theirs() -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for channel in readings:
                allantools.oadev(channel, rate=RATE_HZ, data_type="freq", taus=taus)

    ours = partial(allan_curve, [readings], 1.0 / RATE_HZ)
    figures = (
        Figure("allantools.oadev", processor_s(theirs, runs=3)),
        Figure("`allan_curve`", processor_s(ours, runs=3)),
    )
    return Section("Allan deviations of 3 × 500,000 readings", figures, faster=True)
