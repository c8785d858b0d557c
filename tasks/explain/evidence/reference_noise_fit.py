"""Whether findings describe the unit, or only make the noise of a coarse encoder smaller.

What smooths or shrinks the predicted motion, as a low-pass beside a lead or a dead band does, fits
better for that alone: the motion carries the encoder's noise and the unit does not (attenuation by
errors in the regressor; Fuller, Measurement Error Models, 1987). How much better, a motion with
more of the same noise tells.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from schemas.recording import Recording, Stream
from tasks.explain.evidence.left_over import LeftOver
from tasks.explain.inputs.full_rate import FullRate
from tasks.model.model import Model
from tasks.model.term import TermKey
from tasks.motion.whole import Motion, whole_motion

MOSTLY = 0.5  # of what all findings remove: the noise of the reference explains them
ACTING = 0.1  # of that noise's power: a finding that changes less of it leaves it as it is
SEED = 20


def fitted_to_reference_noise(
    recording: Recording,
    full: FullRate,
    standard: Model,
    found: Model,
    terms: list[Collection[TermKey]],
    left: LeftOver,
) -> set[int]:
    """Numbers of the findings that owe their evidence to the noise of the encoders.

    standard, found: models without and with all findings, fitted. terms: of each finding. left:
    what they leave and what was left without them.
    """
    noisy = with_more_noise(recording, full) if terms else None
    if noisy is None:
        return set()

    def changed(model: Model) -> np.ndarray:
        return np.nan_to_num(model.prediction(noisy) - model.prediction(full.motion))

    def power(errors: np.ndarray) -> float:
        return float(np.where(left.masked, 0.0, errors**2 / left.noise).sum())

    alone, together = changed(standard), changed(found)
    if power(alone) - power(together) < MOSTLY * left.removed:
        return set()
    acting = (power(together - changed(found.without(keys))) for keys in terms)
    return {number for number, own in enumerate(acting) if own > ACTING * power(alone)}


def with_more_noise(recording: Recording, full: FullRate) -> Motion | None:
    """The motion at the unit's rows with as much noise again in each encoder; None without any."""
    encoders, table = full.reference_noise.encoders, recording.table
    if encoders is None or table is None or not encoders.variance.any():
        return None
    rng, t = np.random.default_rng(SEED), table.t - full.start
    thinned = max(1.0, encoders.rate.interval / float(np.median(np.diff(t))))
    columns = dict(table.columns)
    axes = recording.manifest.station.table_axes or ()
    for axis, variance in zip(axes, encoders.variance.T, strict=True):
        deviation = np.sqrt(thinned * np.interp(t, encoders.t, variance))
        name = f"{axis.name}_angle"
        columns[name] = np.unwrap(columns[name]) + deviation * rng.standard_normal(len(t))
    noisier = replace(recording, table=Stream(table.t, columns))
    motion = whole_motion(noisier, full.motion.t + full.start)
    return replace(motion, t=full.motion.t, recorded=full.motion.recorded)
