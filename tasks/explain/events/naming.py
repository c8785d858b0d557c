"""What a line is called: mains pick-up, or a line that nothing in the catalogue names."""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import ACCEL, GYRO
from tasks.explain.events.coherence import Line
from tasks.explain.events.event import UNITS, Event, named

MAINS = (50.0, 60.0)
GRID = 0.15  # Hz that the mains may be off
SAME = 2e-3  # Hz that two lines of one mains may tell it apart
HARMONICS = 3  # those that are looked for at the mains' alias


@dataclass(frozen=True)
class Lines(Event):
    """One source: a line, or those of the mains."""

    lines: tuple[Line, ...]

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        return predicted + sum(line.course(t) for line in self.lines)


def events_of(lines: list[Line], rate: float) -> tuple[Lines, ...]:
    """Those of the mains together, every other by itself.

    A harmonic is one of the mains only beside its fundamental, and at that frequency's multiple:
    by itself, and aliased, any line may lie near one.
    """
    of = [(mains_of(line.frequency, rate), line) for line in lines]
    first = [(each[1], line) for each, line in of if each is not None and each[0] == 1]
    mains = [
        (*each, line) for each, line in of
        if each is not None and first and _agree(each[1], line, *first[0])
    ]  # fmt: skip
    others = [line for line in lines if not any(line is each[2] for each in mains)]
    named_ones = [_mains(sorted(mains, key=lambda each: each[0]))] if mains else []
    return (*map(_unnamed, others), *named_ones)


def _agree(
    sources: tuple[float, ...], line: Line, fundamental: tuple[float, ...], first: Line
) -> bool:
    """Whether two lines may come from mains of one frequency."""
    apart = min(abs(one - other) for one in sources for other in fundamental)
    return apart < SAME + 5 * float(np.hypot(line.u_frequency, first.u_frequency))


def near_mains(frequencies: np.ndarray, rate: float) -> np.ndarray:
    """Which frequencies the mains may be seen at, sampled at a rate."""
    near = np.zeros(len(frequencies), bool)
    for harmonic in range(1, HARMONICS + 1):
        for nominal in MAINS:
            alias = abs(harmonic * nominal - round(harmonic * nominal / rate) * rate)
            near |= np.abs(frequencies - alias) <= harmonic * GRID
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
            within = tuple(sorted(each for each in sources if abs(each - nominal) <= GRID))
            if within:
                return harmonic, within
    return None


def _amplitudes(line: Line, harmonic: int) -> tuple[FoundParameter, ...]:
    """Amplitudes of a line, by channel; a harmonic's carry its number."""
    return tuple(
        FoundParameter(
            name=(GYRO + ACCEL)[channel] + (f"_{harmonic}" if harmonic > 1 else ""),
            value=float(np.abs(line.waves[channel])),
            unit=UNITS[channel // 3],
            u=float(line.u[channel]),
        )
        for channel in line.channels
    )


def _frequency(value: float, u: float) -> FoundParameter:
    return FoundParameter(name="frequency", value=value, unit="Hz", u=u)


def _mains(found: list[tuple[int, tuple[float, ...], Line]]) -> Lines:
    """The event of a mains' lines: harmonic, what the mains' frequency may be, line."""
    harmonic, sources, first = found[0]
    lines = tuple(line for _, _, line in found)
    channels = tuple(sorted({channel for line in lines for channel in line.channels}))
    english, chinese = named(channels)
    at = ", ".join(f"{line.frequency:.4f} Hz" for line in lines)
    # On either side of a fold: nothing tells which, so that the interval holds both.
    u = float(np.hypot(first.u_frequency / harmonic, np.ptp(sources) / 2))
    frequency = _frequency(float(np.mean(sources)), u)
    of = " / ".join(f"{source:.3f}" for source in sources)
    said = (
        f"mains pick-up of {of} Hz, seen at {at}, in the {english}",
        f"工频干扰 {of} Hz，出现在 {at}，通道：{chinese}",
    )
    amplitudes = [each for number, _, line in found for each in _amplitudes(line, number)]
    p_value = min(line.p_value for line in lines)
    return Lines("mains_pickup", channels, (frequency, *amplitudes), p_value, said, None, lines)


def _unnamed(line: Line) -> Lines:
    english, chinese = named(line.channels)
    said = (
        f"a line at {line.frequency:.4f} Hz, there all the time, in the {english}",
        f"{line.frequency:.4f} Hz 处有一条始终存在的谱线，通道：{chinese}",
    )
    parameters = (_frequency(line.frequency, line.u_frequency), *_amplitudes(line, 1))
    return Lines("unnamed", line.channels, parameters, line.p_value, said, None, (line,))
