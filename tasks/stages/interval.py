"""Stage: advice on a unit's recalibration interval, from its own certificates."""

from collections.abc import Sequence
from datetime import date
from itertools import pairwise

from schemas.base import Unusable
from storage.catalogue import certificates
from storage.catalogue.certificates import Entry
from storage.home import Home
from tasks.reminders.reliability import Interval, IntervalAdvice, advise
from tasks.words import Message, message


def interval_advice(serial: str, home: Home) -> tuple[str, int, IntervalAdvice]:
    """The unit, its agreed interval in days, and the advice on it.

    Raises Unusable for a serial number without such a certificate, of several products, or
    whose last certificate has no agreed date.
    """
    entries = [entry for entry in certificates.register(home) if entry.serial == serial]
    return advice_by(entries, serial, home)


def advice_by(of_unit: Sequence[Entry], serial: str, home: Home) -> tuple[str, int, IntervalAdvice]:
    """The same by the certificates of a unit.

    Counted are the intervals between issued certificates whose day of calibration is known; as
    found, where the unit was adjusted. What was inconclusive says nothing of its interval.
    """
    entries = [entry for entry in of_unit if entry.state == "issued" and entry.calibrated_on]
    units = {f"{entry.manufacturer} {entry.model} {entry.serial}" for entry in entries}
    if len(units) != 1:
        found = "there is none" if not units else f"{' and '.join(sorted(units))} have"
        raise Unusable(
            f"The interval of {serial!r} needs issued certificates of one unit with the day of "
            f"calibration; {found}: see `mimucal table certificates`."
        )
    dated = sorted(entries, key=_day)
    verdicts = [_verdict_found(entry, home) for entry in dated]
    history = [
        Interval((_day(later) - _day(earlier)).days, verdict == "pass")
        for (earlier, later), verdict in zip(pairwise(dated), verdicts[1:], strict=True)
        if verdict != "inconclusive" and _day(later) > _day(earlier)
    ]
    last = dated[-1]
    if last.due is None:
        raise Unusable(
            f"Certificate {last.number} has no recalibration date to start from: agree on one in "
            "the order (recalibration_agreed = true)."
        )
    agreed = (last.due - _day(last)).days
    return units.pop(), agreed, advise(history, agreed)


def sentence(unit: str, agreed: int, advice: IntervalAdvice) -> Message:
    """The advice in words."""
    known = advice.days is not None
    return message(
        f"reminder-advice.{advice.advice.replace(' ', '-')}{'' if known else '-unknown'}",
        unit=unit, agreed=str(agreed), intervals=str(advice.intervals),
        conforming=str(advice.conforming), days=f"{advice.days or 0:.0f}",
        shortest=f"{advice.shortest or 0:.0f}", longest=f"{advice.longest or 0:.0f}",
    )  # fmt: skip


def _day(entry: Entry) -> date:
    assert entry.calibrated_on is not None
    return entry.calibrated_on


def _verdict_found(entry: Entry, home: Home) -> str:
    """The verdict on the unit as it came."""
    if not certificates.may_be_as_left(entry):
        return entry.verdict
    record = certificates.record_of(entry, home)
    return (record.as_found or record).decision.verdict
