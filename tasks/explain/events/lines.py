"""Lines: a frequency that is there all the time, as mains pick-up is."""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.stats import gamma

from schemas.discrepancy import FoundParameter
from schemas.recording import ACCEL, GYRO
from tasks.explain.events.event import UNITS, Event, named

MAINS = (50.0, 60.0)
GRID = 0.15  # Hz that the mains may be off
HARMONICS = 3  # those that are looked for at the mains' alias
SLOWEST = 1.0  # Hz; what is slower is left to the regression
FALSE_ALARM = 1e-4  # of one recording
MOST_LINES = 8
PIECES = 24  # of the recording, in each of which a line must be
STRETCH = 512  # bins that tell the level of the noise about a line
TAPER = 0.02  # of the recording, at either end
SEEN = 3.0  # standard uncertainties from which a channel has the line
LONGEST = 4  # times its rows that a recording may last, gaps included


@dataclass(frozen=True)
class Line:
    """A sine wave. waves: (6,) complex, reading Re(wave·exp(2πi·f·t)); u: (6,) of an amplitude.

    power: over that of the noise, summed over channels. p_value: corrected.
    """

    frequency: float
    u_frequency: float
    waves: np.ndarray
    u: np.ndarray
    power: float
    p_value: float

    @property
    def channels(self) -> tuple[int, ...]:
        """The channels that the line is seen in."""
        seen = np.abs(self.waves) > SEEN * self.u
        return tuple(np.flatnonzero(seen).tolist()) or (int(np.argmax(np.abs(self.waves) / self.u)),)

    def course(self, t: np.ndarray) -> np.ndarray:
        """What the line adds to the readings (n, 6), in the channels that have it."""
        added = np.zeros((len(t), 6))
        turn = np.exp(2j * np.pi * self.frequency * t)
        for channel in self.channels:
            added[:, channel] = (self.waves[channel] * turn).real
        return added


@dataclass(frozen=True)
class Lines(Event):
    """One source: a line, or those of the mains."""

    lines: tuple[Line, ...]

    def applied(self, t: np.ndarray, predicted: np.ndarray, noise: np.ndarray) -> np.ndarray:
        return predicted + sum(line.course(t) for line in self.lines)


def find_lines(t: np.ndarray, residual: np.ndarray, noise: np.ndarray) -> tuple[Lines, ...]:
    """Lines in what a fit leaves (n, 6), NaN: not known; noise: (n, 6), its level at each row."""
    if len(t) < 4 * STRETCH:
        return ()
    left = np.where(np.isfinite(residual) & (noise > 0), residual, 0.0)
    weight = np.where((left != 0) & (noise > 0), 1.0 / noise, 0.0)
    found: list[Line] = []
    while len(found) < MOST_LINES:
        line = _strongest(t, left * weight, weight)
        if line is None:
            break
        found.append(line)
        left = np.where(weight > 0, left - line.course(t), 0.0)
    rate = 1 / float(np.median(np.diff(t)))
    return _events(found, rate)


def _strongest(t: np.ndarray, white: np.ndarray, weight: np.ndarray) -> Line | None:
    """The strongest line that is there all the time, of readings divided by their noise."""
    interval = float(np.median(np.diff(t)))
    span = float(t[-1] - t[0]) + interval
    channels = np.flatnonzero(weight.any(axis=0))
    if len(channels) == 0:
        return None
    power, frequencies = _powers(t, white[:, channels], interval)
    if len(power) == 0:
        return None
    threshold = gamma.isf(FALSE_ALARM / len(power), len(channels))
    for _ in range(4):  # a few that come and go may stand before one that stays
        top = int(power.argmax())
        if power[top] < threshold:
            return None
        line = _measured(t, white, weight, frequencies[top], span, len(power))
        if line is not None and line.p_value < FALSE_ALARM:
            return line
        power[max(0, top - 100) : top + 101] = 0.0
    return None


def _powers(
    t: np.ndarray, white: np.ndarray, interval: float
) -> tuple[np.ndarray, np.ndarray]:
    """Powers over the noise about them, summed over channels, and their frequencies (Hz)."""
    place = np.round((t - t[0]) / interval).astype(int)
    if place[-1] > LONGEST * len(t) or (np.diff(place) < 1).any():
        place = np.arange(len(t))
    count = int(place[-1]) + 1
    edge = np.minimum(1.0, np.arange(1, count + 1) / max(TAPER * count, 1.0))
    taper = np.sin(0.5 * np.pi * np.minimum(edge, edge[::-1])) ** 2
    size = next_fast_len(2 * count, real=True)
    frequencies = np.arange(size // 2 + 1) / (size * interval)
    inside = (frequencies > SLOWEST) & (frequencies < 0.5 / interval - 3 / (count * interval))
    total = np.zeros(int(inside.sum()))
    for channel in white.T:
        even = np.zeros(count)
        even[place] = channel
        spectrum = rfft((even - even.mean()) * taper, size)[inside]
        total += _over_noise(spectrum.real**2 + spectrum.imag**2)
    return total, frequencies[inside]


def _over_noise(power: np.ndarray) -> np.ndarray:
    """Power over the mean that its neighbours tell: their median over ln 2."""
    stretches = len(power) // STRETCH
    if stretches == 0:
        return np.zeros(len(power))
    level = np.median(power[: stretches * STRETCH].reshape(stretches, STRETCH), axis=1)
    middle = (np.arange(stretches) + 0.5) * STRETCH
    mean = np.interp(np.arange(len(power)), middle, level) / np.log(2)
    return np.divide(power, mean, out=np.zeros(len(power)), where=mean > 0)


def _measured(
    t: np.ndarray, white: np.ndarray, weight: np.ndarray, near: float, span: float, tried: int
) -> Line | None:
    """The line at about a frequency, by least squares; None if it is not there all the time."""
    turn = np.exp(-2j * np.pi * near * t)
    ends = np.linspace(0, len(t), PIECES + 1).astype(int)[:-1]
    sums = np.add.reduceat((white * weight) * turn[:, None], ends, axis=0)  # (pieces, 6)
    information = np.add.reduceat(weight**2, ends, axis=0) / 2
    middle = np.add.reduceat(t, ends) / np.diff(np.append(ends, len(t)))
    total = information.sum(axis=0)
    has = total > 0
    offsets = np.linspace(-1.0, 1.0, 401) / span
    turned = np.exp(-2j * np.pi * offsets[:, None] * middle) @ sums[:, has]
    powers = (np.abs(turned) ** 2 / (2 * total[has])).sum(axis=1)
    off = offsets[int(powers.argmax())]
    power = float(powers.max())
    pieces = sums[:, has] * np.exp(-2j * np.pi * off * middle)[:, None]
    waves = np.zeros(6, complex)
    waves[has] = pieces.sum(axis=0) / total[has]
    level = _level(white, turn, t, span)
    if not _stays(pieces, information[:, has], waves[has], power, level):
        return None
    u = np.full(6, np.inf)
    u[has] = np.sqrt(level / total[has])
    # Cramér and Rao's bound of the frequency of a sine wave in white noise.
    u_frequency = np.sqrt(1.5 / (power / level)) / (np.pi * span)
    p_value = min(1.0, float(tried * gamma.sf(power / level, has.sum())))
    return Line(near + off, float(u_frequency), waves, u, power, p_value)


def _level(white: np.ndarray, turn: np.ndarray, t: np.ndarray, span: float) -> float:
    """Power of the noise beside the line, over that of white noise."""
    beside = []
    for bins in (-40.5, -30.5, -20.5, 20.5, 30.5, 40.5):
        other = turn * np.exp(-2j * np.pi * bins / span * t)
        count = (white != 0).sum(axis=0)
        sums = np.abs(other @ white) ** 2
        beside.append(np.median(sums[count > 0] / count[count > 0]))
    return float(max(np.mean(beside), 1.0))


def _stays(
    pieces: np.ndarray, information: np.ndarray, waves: np.ndarray, power: float, level: float
) -> bool:
    """Whether every piece of the recording has the same wave, as far as noise allows."""
    told = information > 0
    each = np.divide(pieces, information, out=np.zeros_like(pieces), where=told)
    off = float((information * np.abs(each - waves) ** 2).sum() / 2 / level)
    freedom = float(told.sum() - len(waves))
    return off - freedom < 0.3 * power / level + 4 * np.sqrt(freedom)


def _events(lines: list[Line], rate: float) -> tuple[Lines, ...]:
    """Those of the mains together, every other by itself."""
    mains = [(line, of) for line in lines if (of := mains_of(line.frequency, rate)) is not None]
    rest = [line for line in lines if mains_of(line.frequency, rate) is None]
    events = [_unnamed(line) for line in rest]
    if mains:
        events.append(_mains([line for line, _ in mains], [of for _, of in mains]))
    return tuple(events)


def mains_of(frequency: float, rate: float) -> tuple[int, float] | None:
    """Which harmonic of the mains is seen at a frequency, sampled at a rate, and their frequency.

    Hz. None where no harmonic, or its alias, lies there.
    """
    for harmonic in range(1, HARMONICS + 1):
        for nominal in MAINS:
            fold = round(harmonic * nominal / rate)
            for alias in (fold - 1, fold, fold + 1):
                for side in (1.0, -1.0):
                    source = (alias * rate + side * frequency) / harmonic
                    if abs(source - nominal) <= GRID:
                        return harmonic, source
    return None


def _parameters(lines: list[Line], of: list[tuple[int, float]]) -> tuple[FoundParameter, ...]:
    first, (harmonic, source) = lines[0], of[0]
    found = [
        FoundParameter(name="frequency", value=source, unit="Hz", u=first.u_frequency / harmonic)
    ]
    for line, (number, _) in zip(lines, of, strict=True):
        for channel in line.channels:
            name = (GYRO + ACCEL)[channel] + (f"_{number}" if number > 1 else "")
            found.append(
                FoundParameter(
                    name=name, value=float(np.abs(line.waves[channel])),
                    unit=UNITS[channel // 3], u=float(line.u[channel]),
                )
            )  # fmt: skip
    return tuple(found)


def _channels(lines: list[Line]) -> tuple[int, ...]:
    return tuple(sorted({channel for line in lines for channel in line.channels}))


def _mains(lines: list[Line], of: list[tuple[int, float]]) -> Lines:
    order = sorted(range(len(lines)), key=lambda k: of[k][0])
    lines, of = [lines[k] for k in order], [of[k] for k in order]
    channels = _channels(lines)
    english, chinese = named(channels)
    at = ", ".join(f"{line.frequency:.4f} Hz" for line in lines)
    said = (
        f"mains pick-up of {of[0][1]:.3f} Hz, seen at {at}, in the {english}",
        f"工频干扰 {of[0][1]:.3f} Hz，出现在 {at}，通道：{chinese}",
    )
    p_value = min(line.p_value for line in lines)
    parameters = _parameters(lines, of)
    return Lines("mains_pickup", channels, parameters, p_value, said, None, tuple(lines))


def _unnamed(line: Line) -> Lines:
    english, chinese = named(line.channels)
    said = (
        f"a line at {line.frequency:.4f} Hz, there all the time, in the {english}",
        f"{line.frequency:.4f} Hz 处有一条始终存在的谱线，通道：{chinese}",
    )
    parameters = _parameters([line], [(1, line.frequency)])
    return Lines("unnamed", line.channels, parameters, line.p_value, said, None, (line,))
