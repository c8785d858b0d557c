"""Truth recovery: what an ideal run without noise says of a unit whose truth is known."""

from schemas.validation import Check
from tasks.validation.coverage import Calibrate, errors_of, simulate
from tasks.validation.record import WITHOUT_EARTH, checked
from tasks.words import message

MAX_ERROR = 1e-9  # in the printed unit of the item


def recovery_checks(method: str, calibrate: Calibrate, seed: int) -> dict[str, Check]:
    """Largest error of each item in an ideal run: no noise, no errors of the equipment."""
    recording, truth = simulate(method, seed, ideal=True)
    calibration = calibrate(recording, run="ideal", code_version="-")
    errors = errors_of(calibration, truth)
    checks = {}
    for name, elements in errors.items():
        largest = max(abs(error) for error, *_ in elements.values())
        unit = calibration.items["gyro_g_sensitivity" if name == WITHOUT_EARTH else name].unit
        stated = message(
            "validation-recovery", error=f"{largest:.1e}", unit=unit, close=f"{MAX_ERROR:.0e}"
        )
        checks[name] = checked(largest <= MAX_ERROR, stated)
    return checks
