"""Excess that is periodic: in the angle of a table axis, or in time."""

import numpy as np

from tasks.explain.locate.excess import ChannelExcess
from tasks.explain.locate.patterns import Pattern, concentration, cost, fit_information
from tasks.explain.locate.rotation import MAX_HARMONIC, Rotation
from tasks.explain.locate.run import Run
from tasks.words import message

MAX_LISTED = 3  # numbers of waves that are named together
MIN_RELATIVE = 0.2  # of the strongest, from which a further number of waves is named beside it
MIN_PERIODS = 8  # in the run: slower is a trend
WIDTH, BESIDE = 0.005, 2  # of the frequency, and lines beside it, that belong to it


def harmonics_pattern(run: Run, rotation: Rotation, excess: ChannelExcess) -> Pattern:
    """The numbers of waves per turn of an axis that hold most of an excess."""
    values, whole = excess.values, excess.power
    power = rotation.harmonic_power(values)
    order = np.argsort(-power)[:MAX_LISTED]
    kept = order[power[order] >= MIN_RELATIVE * power[order[0]]]
    turning = float((values[rotation.rows] ** 2).sum())
    held = min(float(power[kept].sum()), turning)
    rows = np.array([len(rotation.rows), len(values) - len(rotation.rows)], float)
    left = np.array([turning - held, whole - turning])
    paid = cost(2 * len(kept), MAX_HARMONIC, run.intervals)
    numbers = dict(zip(("first", "second", "third"), map(str, sorted(kept + 1)), strict=False))
    waves = "locate-one-wave" if kept.tolist() == [0] else f"locate-waves-{len(kept)}"
    description = message(
        "locate-harmonics", share=f"{held / whole:.0%}", waves=message(waves, **numbers),
        axis=rotation.name,
    )  # fmt: skip
    mask = np.zeros(len(values), bool)
    mask[rotation.rows] = True
    score = concentration(rows, left, whole) - paid
    return Pattern("rotation_phase", score, description, mask[run.starts])


def frequency_pattern(run: Run, excess: ChannelExcess) -> Pattern | None:
    """The frequency at which an excess has most of its power."""
    count = len(excess.values)
    power = np.abs(np.fft.rfft(excess.values)) ** 2
    if len(power) < 2 * MIN_PERIODS or count < 2:
        return None
    power[1 : (count + 1) // 2] *= 2
    lines = np.arange(MIN_PERIODS, len(power))
    reach = BESIDE + (WIDTH * lines).astype(int)
    summed = np.concatenate([[0.0], np.cumsum(power)])
    held = summed[np.minimum(lines + reach + 1, len(power))] - summed[lines - reach]
    most = int(held.argmax())
    share = float(held[most] / power.sum())
    band = slice(lines[most] - reach[most], lines[most] + reach[most] + 1)
    line = band.start + int(power[band].argmax())
    around = np.arange(line - 1, min(line + 2, len(power)))
    hertz = float(around @ power[around] / power[around].sum()) / (count * run.motion.interval)
    description = message("locate-frequency", share=f"{share:.0%}", frequency=f"{hertz:.4g}")
    score = fit_information(share) - cost(2, len(lines), run.intervals)
    return Pattern("frequency", score, description, np.ones(len(run.t), bool))
