"""The lattice of codes that a channel's readings lie on."""

from dataclasses import dataclass

import numpy as np

OFF_CODE = 0.05  # of a step: how far a reading may lie off its code, for the rounding of a file
MIN_ON_CODE = 0.98  # share of the values that must lie on the codes; a limit need not
MOST_OFF = 0.1  # of those near by: no lattice
NEAREST = 60  # differences, the lesser half, of which the divisor is sought
MIN_PART = 1e-3  # of the least difference: less is no step
DENSE = 12  # different readings, among which no code is missing
OUTWARDS = (
    40.0,
    150.0,
    600.0,
    2500.0,
    1e4,
    1e5,
    np.inf,
)  # codes, so that a rough step counts right
DECIMAL = 1e-6  # of a power of ten: the step of a file in rad/s or m/s², and of no unit
OFF_OTHER_CODES = 0.3  # step: by which rounded readings may lie off another channel's codes
ROUNDED = 0.6  # decimals by which a rounded reading may be off its code


@dataclass(frozen=True)
class Quantiser:
    """Readings are offset + step·k with whole k; step: rad/s or m/s²."""

    step: float
    offset: float

    @property
    def through_zero(self) -> bool:
        """Whether zero is a code, so that the numbers that the unit sent are known."""
        return abs(self.offset) < OFF_CODE * self.step

    def codes(self, readings: np.ndarray) -> np.ndarray:
        """The number (n,) of each reading, whole as a float; NaN stays."""
        return np.asarray(np.rint((readings - self.offset) / self.step))


def quantiser_of(readings: np.ndarray) -> Quantiser | None:
    """The codes of one channel (n,), by the common divisor of the differences of its readings.

    None for a dead channel and for readings without a step.
    """
    values = np.unique(readings[np.isfinite(readings)])
    if len(values) < 3:
        return None
    apart = np.diff(values)
    apart = apart[apart > 1e-9 * np.abs(values).max()]
    if len(apart) < 2:
        return None
    places = np.rint(np.linspace(0.0, 0.5, NEAREST) * (len(apart) - 1)).astype(int)
    lesser = np.sort(np.partition(apart, places[-1])[: places[-1] + 1])
    return _through(values, float(lesser[0])) or _through(
        values, _common_divisor(lesser[places].tolist())
    )


def code_lattices(readings: np.ndarray) -> dict[int, Quantiser]:
    """The lattice of the numbers that a unit sent, by channel of its readings (n, 6), where zero is
    on it. Channels of a triad have one step unless they show another.
    """
    found = {c: q for c, q in enumerate(map(code_lattice, readings.T)) if q is not None}
    for c in set(range(readings.shape[1])) - found.keys():
        for other in (each for each in list(found) if each // 3 == c // 3):
            numbers = readings[np.isfinite(readings[:, c]), c] / found[other].step
            if (
                len(numbers)
                and np.mean(np.abs(numbers - np.rint(numbers)) < OFF_OTHER_CODES) > MIN_ON_CODE
            ):
                found[c] = found[other]
                break
    return found


def code_lattice(readings: np.ndarray) -> Quantiser | None:
    """The lattice of one channel's numbers, by its readings (n,).

    A file that rounds to decimals has a lattice of its own; the numbers beneath show by the
    decimals that never occur where readings are dense, unless these are coarser.
    """
    found = quantiser_of(readings)
    if found is None:
        return None
    values, counts = np.unique(found.codes(readings[np.isfinite(readings)]), return_counts=True)
    digits = float(np.log10(found.step))
    decimals = abs(digits - round(digits)) < DECIMAL
    if len(values) > DENSE:
        within = np.convolve(counts, np.ones(DENSE), mode="valid")
        first = int(within.argmax())
        gaps = np.diff(values[first : first + DENSE])
        if gaps.max() > 1.0 and np.ptp(gaps) <= 1.0:
            found = _beneath(values, first, float(gaps.mean()), found)
            decimals = False
    return found if found is not None and found.through_zero and not decimals else None


def _beneath(values: np.ndarray, first: int, wide: float, fine: Quantiser) -> Quantiser | None:
    """The lattice that whole decimals (n,) were rounded from, by dense ones from `first` on.

    wide: decimals that its codes are apart, roughly.
    """
    origin = values[first]
    for span in (DENSE, *OUTWARDS):
        near = values[np.abs(values - origin) <= span * wide]
        numbers = np.round((near - origin) / wide)
        slope, start = np.polyfit(numbers, near, 1)
        if (np.abs(near - start - slope * numbers) > ROUNDED).mean() > 1.0 - MIN_ON_CODE:
            return None
        wide, origin = float(slope), float(start)
    offset = origin - wide * round(origin / wide)
    if abs(offset) > ROUNDED:
        return None
    return Quantiser(wide * fine.step, 0.0)


def _common_divisor(apart: list[float]) -> float:
    """The largest number that differences, smallest first, are whole multiples of, after Euclid."""
    step = apart[0]
    for one in apart:
        left = abs(one - step * round(one / step))
        while left > OFF_CODE * step > MIN_PART * apart[0]:
            step, left = left, abs(step - left * round(step / left))
    return step


def _through(values: np.ndarray, step: float) -> Quantiser | None:
    """The lattice through different values (n,) with about this step, if they lie on it."""
    origin = float(values[np.abs(values).argmin()])
    for span in (30.0, 1e3, 1e5, np.inf):  # outwards, for a rough step miscounts what is far
        near = values[np.abs(values - origin) <= span * step]
        codes = np.round((near - origin) / step)
        if codes.any():
            of_mean = codes - codes.mean()
            step = float(of_mean @ near / (of_mean @ of_mean))
            origin = float(near.mean() - step * codes.mean())
            if (np.abs(near - origin - step * codes) > OFF_CODE * step).mean() > MOST_OFF:
                return None
    off = np.abs(values - origin - step * np.round((values - origin) / step))
    if not (off <= OFF_CODE * step).mean() >= MIN_ON_CODE:
        return None
    return Quantiser(step, origin - step * round(origin / step))
