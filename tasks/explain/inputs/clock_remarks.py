"""What the station recorded about the unit's clock, for anyone who has to judge a delay."""

from pydantic import ValidationError

from schemas.recording import Recording
from schemas.unit_link import ClockComparison
from tasks.model.terms.timing import TIME_OFFSET
from tasks.words import Sayable, message

COVERAGE = 2.0


def clock_remarks(recording: Recording) -> tuple[Sayable, ...]:
    """The part of a delay due to the clocks, τ = −offset of the recorded stamps, with its U.

    It is reported, but not used as a prior of the delay, since the unit's own filter is not part of
    it. None if the recording has no comparison with its half-width; if U exceeds a plausible delay,
    as on a virtual station that runs fast; and for a unit that was switched on again, whose clock
    was reset.
    """
    kept = recording.manifest.model_extra or {}
    try:
        clock = ClockComparison.model_validate(kept.get("unit_clock"))
        moved_s = float(kept.get("unit_clock_shift_s", 0.0))
    except (ValidationError, TypeError, ValueError):
        return ()
    expanded_s = COVERAGE * clock.u_offset_s
    _, largest_s = TIME_OFFSET.parameters[0].plausible
    if "unit_power_on_s" in kept or expanded_s > largest_s:
        return ()
    delay, U = (f"{1e3 * seconds:.1f}" for seconds in (moved_s - clock.offset_s, expanded_s))
    return (message("reference-unit-clock", delay=delay, U=U),)
