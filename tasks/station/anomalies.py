"""Anomalies noticed during a run, and the remarks they become."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

from schemas.procedure import EnvironmentLimits
from schemas.recording import Segment
from schemas.text import Remark
from tasks.words import message, remark

MEASURED = ("static", "rate", "rotation")
MAX_NAMED = 3
# What makes a segment worth measuring again: a moment's fault of table, line or unit.
FAILURES = (
    "encoder_gap", "unit_lost_samples", "table_unsettled", "table_rate", "stuck_channel", "spikes",
)  # fmt: skip
CONDITIONS = ("air_temperature", "air_humidity")  # of the specification: clause 6
DECIMALS = {"air_temperature": ".1f", "air_humidity": ".0f", "table_rate": "+.3f"}


@dataclass(frozen=True)
class Anomaly:
    """Something noticed between two times (s): `amount` counts it or is the value read.

    code: one of the messages `station-…` of the catalogues. subject: an axis or a channel.
    """

    code: str
    t_start: float
    t_end: float
    amount: float = 1.0
    subject: str = ""


def touches(segment: Segment, anomalies: Iterable[Anomaly]) -> bool:
    """Whether it is a measured one, and any of them was while it was measured."""
    return segment.kind in MEASURED and any(
        anomaly.t_start < segment.t_end and anomaly.t_end >= segment.t_start
        for anomaly in anomalies
    )


def remarks_on(
    anomalies: Iterable[Anomaly], segments: Sequence[Segment], limits: EnvironmentLimits
) -> tuple[Remark, ...]:
    """One remark for each kind of anomaly and subject, with the measured segments it touches.

    A condition of the specification that was broken only between measured segments does not
    stop a unit from passing.
    """

    def key(anomaly: Anomaly) -> tuple[str, str]:
        return anomaly.code, anomaly.subject

    groups = groupby(sorted(anomalies, key=key), key=key)
    return tuple(_remark(tuple(group), segments, limits) for _, group in groups)


def _remark(
    anomalies: tuple[Anomaly, ...], segments: Sequence[Segment], limits: EnvironmentLimits
) -> Remark:
    code = anomalies[0].code
    touched = tuple(segment.name for segment in segments if touches(segment, anomalies))
    amounts = [anomaly.amount for anomaly in anomalies]
    decimals = DECIMALS.get(code, ".0f")
    sentence = message(
        f"station-{code.replace('_', '-')}",
        subject=anomalies[0].subject,
        total=f"{sum(amounts):.0f}",
        low=format(min(amounts), decimals),
        high=format(max(amounts), decimals),
        limits=_limits(code, limits),
        place=message(
            "station-place",
            names=touched[:MAX_NAMED],
            count=len(touched),
            more=max(len(touched) - MAX_NAMED, 0),
        ),
    )
    return remark(code, sentence, touched, blocks_pass=code in CONDITIONS and bool(touched))


def _limits(code: str, limits: EnvironmentLimits) -> str:
    low, high = limits.humidity_percent if code == "air_humidity" else limits.temperature_degc
    return f"{low:g}–{high:g}"
