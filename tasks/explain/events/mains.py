"""Which spectral lines are mains pick-up, aliased or not, and the events that lines make."""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event, amplitude_parameter, channel_names
from tasks.explain.events.line_fit import Line
from tasks.words import message

MAINS = (50.0, 60.0)  # Hz
TOLERANCE = 0.15  # Hz that the mains may be off
SAME = 2e-3  # Hz by which two lines of one mains may differ on its frequency
HARMONICS = 3  # those that are looked for at the mains' alias


@dataclass(frozen=True)
class SpectralLines(Event):
    """One source: a line, or those of the mains."""

    lines: tuple[Line, ...]

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return predicted + sum(line.signal(t) for line in self.lines)


@dataclass(frozen=True)
class MainsLine:
    """A line that may be a harmonic of the mains; frequencies: that the mains then has, Hz."""

    harmonic: int
    frequencies: tuple[float, ...]
    line: Line

    def agrees_with(self, other: "MainsLine") -> bool:
        """Whether both may come from mains of one frequency."""
        apart = min(abs(a - b) for a in self.frequencies for b in other.frequencies)
        u = float(np.hypot(self.line.u_frequency, other.line.u_frequency))
        return apart < SAME + 5 * u


def events_of_lines(lines: list[Line], rate: float) -> tuple[SpectralLines, ...]:
    """Those of the mains together, every other by itself; rate: of the samples, Hz.

    A harmonic is one of the mains only beside its fundamental, and at that frequency's multiple:
    by itself, and aliased, any line may lie near one.
    """
    sources = [(line, mains_of(line.frequency, rate)) for line in lines]
    near = [MainsLine(*source, line) for line, source in sources if source is not None]
    fundamental = next((each for each in near if each.harmonic == 1), None)
    mains = [each for each in near if fundamental and each.agrees_with(fundamental)]
    frequencies = {each.line.frequency for each in mains}
    others = tuple(_unnamed(line) for line in lines if line.frequency not in frequencies)
    return (*others, _mains(mains)) if mains else others


def at_mains(frequencies: np.ndarray, rate: float) -> np.ndarray:
    """Which frequencies (k,) Hz the mains may be seen at, sampled at a rate (Hz): (k,) bool."""
    near = np.zeros(len(frequencies), bool)
    for harmonic in range(1, HARMONICS + 1):
        for nominal in MAINS:
            alias = abs(harmonic * nominal - round(harmonic * nominal / rate) * rate)
            near |= np.abs(frequencies - alias) <= harmonic * TOLERANCE
    return near


def mains_of(frequency: float, rate: float) -> tuple[int, tuple[float, ...]] | None:
    """Which harmonic of the mains is seen at a frequency (Hz), sampled at a rate (Hz).

    With it what the mains' frequency may be: two, where both sides of a fold are within reach.
    None where no harmonic, or its alias, lies there.
    """
    for harmonic in range(1, HARMONICS + 1):
        for nominal in MAINS:
            fold = round(harmonic * nominal / rate)
            aliases = {alias * rate + side * frequency
                       for alias in (fold - 1, fold, fold + 1) for side in (1, -1)}  # fmt: skip
            sources = {alias / harmonic for alias in aliases}
            within = tuple(sorted(each for each in sources if abs(each - nominal) <= TOLERANCE))
            if within:
                return harmonic, within
    return None


def _parameters(
    frequency: float, u: float, lines: list[tuple[int, Line]]
) -> tuple[FoundParameter, ...]:
    """The frequency, and each line's amplitudes by channel; a harmonic's carry its number."""
    return (
        FoundParameter(name="frequency", value=frequency, unit="Hz", u=u),
        *(
            amplitude_parameter(
                channel, float(np.abs(line.amplitudes[channel])), float(line.u[channel]),
                f"_{harmonic}" if harmonic > 1 else "",
            )
            for harmonic, line in lines for channel in line.channels
        ),
    )  # fmt: skip


def _mains(found: list[MainsLine]) -> SpectralLines:
    """The event of a mains' lines."""
    found = sorted(found, key=lambda each: each.harmonic)
    first, lines = found[0], tuple(each.line for each in found)
    channels = tuple(sorted({channel for line in lines for channel in line.channels}))
    # On either side of a fold: nothing tells which, so that the interval holds both.
    u = float(np.hypot(first.line.u_frequency / first.harmonic, np.ptp(first.frequencies) / 2))
    parameters = _parameters(
        float(np.mean(first.frequencies)), u, [(each.harmonic, each.line) for each in found]
    )
    description = message(
        "events-mains", frequency=" / ".join(f"{each:.3f}" for each in first.frequencies),
        lines=", ".join(f"{line.frequency:.4f} Hz" for line in lines),
        channels=channel_names(channels),
    )  # fmt: skip
    p_value = min(line.p_value for line in lines)
    return SpectralLines("mains_pickup", channels, parameters, p_value, description, lines)


def _unnamed(line: Line) -> SpectralLines:
    parameters = _parameters(line.frequency, line.u_frequency, [(1, line)])
    description = message(
        "events-line", frequency=f"{line.frequency:.4f}", channels=channel_names(line.channels)
    )
    return SpectralLines("unnamed", line.channels, parameters, line.p_value, description, (line,))
