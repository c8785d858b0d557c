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
FEW = 4  # pieces that must not make up more than so much of a line:
SHARE = 0.5
IN = 0.8  # of the pieces must have a part in the line
PART = 0.5  # of what a line would have there, that rests and turns must have
NEARLY = 0.6  # of the power that is sure: from here a line is measured closely
BESIDE = 40  # bins beside a line that are not looked at again: no line is quite sharp
CANDIDATES = 5  # that are measured: some come and go, and stand before one that stays
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
        strongest = int(np.argmax(np.abs(self.waves) / self.u))
        return tuple(np.flatnonzero(seen).tolist()) or (strongest,)

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


def find_lines(
    t: np.ndarray, residual: np.ndarray, noise: np.ndarray, turning: np.ndarray
) -> tuple[Lines, ...]:
    """Lines in what a fit leaves (n, 6), NaN: not known; noise: (n, 6), its level at each row.

    turning: (n,) bool; what is there only while the table turns, or only at rest, is no line.
    """
    if len(t) < 4 * STRETCH:
        return ()
    left = np.where(np.isfinite(residual) & (noise > 0), residual, 0.0)
    weight = np.where((left != 0) & (noise > 0), 1.0 / noise, 0.0)
    found, kept = list[Line](), list[Line]()
    while len(found) < MOST_LINES:
        line = _strongest(t, left * weight, weight, [each.frequency for each in found])
        if line is None:
            break
        found.append(line)
        if _both(t, left * weight, weight, turning, line):
            kept.append(line)
        left = np.where(weight > 0, left - line.course(t), 0.0)
    rate = 1 / float(np.median(np.diff(t)))
    return _events(kept, rate)


def _strongest(
    t: np.ndarray, white: np.ndarray, weight: np.ndarray, known: list[float]
) -> Line | None:
    """The strongest line that is there all the time, of readings divided by their noise."""
    interval = float(np.median(np.diff(t)))
    span = float(t[-1] - t[0]) + interval
    channels = np.flatnonzero(weight.any(axis=0))
    if len(channels) == 0:
        return None
    power, frequencies = _powers(t, white[:, channels], interval)
    if len(power) == 0:
        return None
    for frequency in known:
        power[np.abs(frequencies - frequency) < BESIDE / span] = 0.0
    threshold = NEARLY * gamma.isf(FALSE_ALARM / len(power), len(channels))
    in_mains = _near_mains(frequencies, 1 / interval)
    for _ in range(CANDIDATES):
        top = int(power.argmax())
        if power[top] < threshold:
            return None
        tried = int(in_mains.sum()) if in_mains[top] else len(power)
        line = _measured(t, white, weight, frequencies[top], span, tried)
        if line is not None:
            return line
        power[max(0, top - 100) : top + 101] = 0.0
    return None


def _near_mains(frequencies: np.ndarray, rate: float) -> np.ndarray:
    """Which frequencies the mains may be seen at, sampled at a rate."""
    near = np.zeros(len(frequencies), bool)
    for harmonic in range(1, HARMONICS + 1):
        for nominal in MAINS:
            alias = abs(harmonic * nominal - round(harmonic * nominal / rate) * rate)
            near |= np.abs(frequencies - alias) <= harmonic * GRID
    return near


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
    powers = np.abs(turned) ** 2 / (2 * total[has])
    best = int(powers.sum(axis=1).argmax())
    off, power = offsets[best], float(powers[best].sum())
    pieces = sums[:, has] * np.exp(-2j * np.pi * off * middle)[:, None]
    waves = np.zeros(6, complex)
    waves[has] = pieces.sum(axis=0) / total[has]
    if tried * gamma.sf(power, has.sum()) > FALSE_ALARM:
        return None
    level = _level(white[:, has], turn, t, span)
    power = float((powers[best] / level).sum())
    p_value = min(1.0, float(tried * gamma.sf(power, has.sum())))
    stays = _stays(pieces, information[:, has], waves[has], power, level)
    if p_value > FALSE_ALARM or not stays:
        return None
    u = np.full(6, np.inf)
    u[has] = np.sqrt(level / total[has])
    # Cramér and Rao's bound of the frequency of a sine wave in white noise.
    u_frequency = np.sqrt(1.5 / power) / (np.pi * span)
    return Line(near + off, float(u_frequency), waves, u, power, p_value)


def _level(white: np.ndarray, turn: np.ndarray, t: np.ndarray, span: float) -> np.ndarray:
    """Power (channels,) of the noise beside the line, over that of white noise."""
    count = np.maximum((white != 0).sum(axis=0), 1)
    steps = 20.5 + 5.0 * np.arange(8)
    total = np.zeros(white.shape[1])
    for bins in np.concatenate([-steps, steps]):
        other = turn * np.exp(-2j * np.pi * bins / span * t)
        total += np.abs(other @ white) ** 2 / count
    return np.maximum(total / (2 * len(steps)), 1.0)


def _stays(
    pieces: np.ndarray, information: np.ndarray, waves: np.ndarray, power: float, level: np.ndarray
) -> bool:
    """Whether every piece of the recording has the same wave, as far as noise allows."""
    told = information > 0
    each = np.divide(pieces, information, out=np.zeros_like(pieces), where=told)
    off = float((information * np.abs(each - waves) ** 2 / level).sum() / 2)
    freedom = float(told.sum() - len(waves))
    shares = np.sort((pieces * waves.conj()).real.sum(axis=1))[::-1]
    heard = told.any(axis=1).sum()
    spread = bool(shares[:FEW].sum() < SHARE * shares.sum() and (shares > 0).sum() > IN * heard)
    return spread and off - freedom < 0.3 * power + 4 * np.sqrt(freedom)


def _both(
    t: np.ndarray, white: np.ndarray, weight: np.ndarray, turning: np.ndarray, line: Line
) -> bool:
    """Whether rows at rest and rows that turn have their parts in a line."""
    wave = np.exp(-2j * np.pi * line.frequency * t)
    for rows in (turning, ~turning):
        information = (weight[rows] ** 2).sum(axis=0) / 2
        expected = float((information * np.abs(line.waves) ** 2).sum())
        sums = wave[rows] @ (white[rows] * weight[rows])
        if (sums * line.waves.conj()).real.sum() < PART * expected:
            return False
    return True


def _events(lines: list[Line], rate: float) -> tuple[Lines, ...]:
    """Those of the mains together, every other by itself."""
    mains: list[tuple[int, tuple[float, ...], Line]] = []
    events = []
    for line in lines:
        of = mains_of(line.frequency, rate)
        if of is None:
            events.append(_unnamed(line))
        else:
            mains.append((*of, line))
    if mains:
        events.append(_mains(sorted(mains, key=lambda each: each[0])))
    return tuple(events)


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


def _channels(lines: list[Line]) -> tuple[int, ...]:
    return tuple(sorted({channel for line in lines for channel in line.channels}))


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
    return Lines(
        "mains_pickup", channels, (frequency, *amplitudes), p_value, said, None, lines
    )


def _unnamed(line: Line) -> Lines:
    english, chinese = named(line.channels)
    said = (
        f"a line at {line.frequency:.4f} Hz, there all the time, in the {english}",
        f"{line.frequency:.4f} Hz 处有一条始终存在的谱线，通道：{chinese}",
    )
    parameters = (_frequency(line.frequency, line.u_frequency), *_amplitudes(line, 1))
    return Lines("unnamed", line.channels, parameters, line.p_value, said, None, (line,))
