"""Describes where the excess of a finding lies: channel, circumstances and segments.

The excess of a finding is what the standard's model cannot absorb of its contribution. Each
channel's part of it is compared with every way of partitioning the run (by rate, by attitude, by
temperature …); the one that leaves least unexplained is where it sits.
"""

import numpy as np

from schemas.discrepancy import Where
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation, Finding
from tasks.explain.locate.excess import ChannelExcess, StandardDesign, noise_scales
from tasks.explain.locate.place import Place, places
from tasks.explain.locate.run_blocks import BlockedRun
from tasks.words import message, statement

MIN_SHARE = 0.05  # of a finding's excess, from which a channel has an entry of its own
NEGLIGIBLE = 1e-4  # share of the other channels together that is not worth an entry
ROUNDING = 1e-6  # square sum, in variances of the noise, that is arithmetic
ABSORBED = Place("level", message("locate-absorbed"), ())
SLIGHT = Place("level", message("locate-slight"), ())


def locate(explanation: Explanation) -> tuple[tuple[Where, ...], ...]:
    """For each finding where its excess sits, by falling share; the shares add up to 1.

    A channel with 5 % or more of the excess has one entry, its share that of the channel. What
    the others hold is a last entry of dimension “level”, their names separated by commas. A
    finding without excess has one entry, “level”, at its first channel.
    """
    if not explanation.findings:
        return ()
    run = BlockedRun.of(explanation.recording)
    designs = tuple(StandardDesign.of(run, channel) for channel in range(len(CHANNELS)))
    noise = noise_scales(explanation.noise)
    return tuple(
        _entries(run, finding, _signal(finding, explanation), designs, noise)
        for finding in explanation.findings
    )


def _signal(finding: Finding, explanation: Explanation) -> np.ndarray:
    """(n, 6) what is located: a finding's contribution; of what nothing explains, the residual in
    its channels.
    """
    if not finding.remainder:
        return finding.contribution
    residual = explanation.recording.imu.stack(CHANNELS) - explanation.found
    return np.where(np.isin(np.arange(len(CHANNELS)), finding.channels), residual, 0.0)


def _entries(
    run: BlockedRun, finding: Finding, signal: np.ndarray, designs: tuple[StandardDesign, ...],
    noise: np.ndarray,
) -> tuple[Where, ...]:  # fmt: skip
    """signal: (n, 6) to be located. noise: (6,) standard deviations, which it is counted in."""
    scaled = signal / noise
    excess = [design.residual(column) for design, column in zip(designs, scaled.T, strict=True)]
    power = np.array([float((values**2).sum()) for values in excess])
    if power.sum() < ROUNDING:
        return (_where(CHANNELS[(*finding.channels, 0)[0]], ABSORBED, 1.0),)
    share = power / power.sum()
    major = [int(c) for c in np.argsort(-share) if share[c] >= MIN_SHARE]
    channels = {c: ChannelExcess.of(run, excess[c], designs[c], c, float(noise[c])) for c in major}
    placed = places(run, channels, signal)
    entries = [_where(CHANNELS[c], placed[c], float(share[c])) for c in major]
    rest = 1.0 - sum(each.share for each in entries)
    if rest > NEGLIGIBLE:
        slight = ", ".join(CHANNELS[c] for c in range(6) if 0 < share[c] < MIN_SHARE)
        return (*entries, _where(slight, SLIGHT, rest))
    first = entries[0].model_copy(update={"share": entries[0].share + rest})
    return (first, *entries[1:])


def _where(channel: str, place: Place, share: float) -> Where:
    return Where(
        channel=channel, dimension=place.dimension, description=statement(place.description),
        segments=place.segments, share=share,
    )  # fmt: skip
