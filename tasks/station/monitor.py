"""Checks finished segments during the run, so that the operator hears of faults at once."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from schemas.procedure import EnvironmentLimits
from schemas.recording import ANGLE, MEASURED, Segment, Stream, joined
from schemas.text import Remark
from schemas.unit_link import UnitLink
from tasks.readings.robust import TO_SIGMA
from tasks.words import message, remark

# Anomalies noticed during a run, and the remarks they become.

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


RATE_TOLERANCE = 5e-4  # JJF 2003 table 1: rates are steady to 0.05 %
SPIKE_SIGMAS = 20.0
SPIKE_COUNTS = 20.0
ENOUGH = 20_000  # samples that tell a channel's own noise; all of a long segment would hold the
# loop up that the table's watchdog listens to


def check_unit(segment: Segment, imu: Stream, link: UnitLink) -> list[Anomaly]:
    """Channels that stand still, and samples far outside their channel's own noise.

    Of an accumulated angle the increments are looked at; at rest it may stand still. A turn from
    rest to rest has no noise of its own to judge by.
    """
    if segment.kind == "rotation":
        return []
    rows = imu.rows(segment.t_start, segment.t_end)
    anomalies = []
    for name, count in link.frame.channels.items():
        if name == "temperature":
            continue
        values = imu.columns[name][rows]
        if name in ANGLE:
            values = np.diff(values)
        if len(values) < 2:
            continue
        some = values[:: max(1, len(values) // ENOUGH)]
        middle = float(np.median(some))
        deviation = np.abs(values - middle)
        if not np.ptp(values) and not (name in ANGLE and segment.kind == "static"):
            anomalies.append(_anomaly("stuck_channel", segment, name))
        noise = TO_SIGMA * float(np.median(np.abs(some - middle)))
        spikes = int(np.count_nonzero(deviation > SPIKE_SIGMAS * noise + SPIKE_COUNTS * count))
        if spikes:
            anomalies.append(_anomaly("spikes", segment, name, spikes))
    return anomalies


def check_rate(
    segment: Segment, axis: str, table: Stream, half_width_s: float = 0.0
) -> list[Anomaly]:
    """The mean rate of a table axis by its encoder against the rate asked for.

    half_width_s: by how much the time of an angle may be wrong, at both ends.
    """
    rows = table.rows(segment.t_start, segment.t_end)
    t, angle = table.t[rows], table.columns[f"{axis}_angle"][rows]
    if segment.kind != "rate" or segment.rate_deg_s is None or len(t) < 2:
        return []
    rate = np.degrees((angle[-1] - angle[0]) / (t[-1] - t[0]))
    error = float(rate / segment.rate_deg_s - 1.0)
    if abs(error) <= RATE_TOLERANCE + 2.0 * half_width_s / (t[-1] - t[0]):
        return []
    return [_anomaly("table_rate", segment, axis, 100.0 * error)]


class SegmentMonitor:
    """Segments waiting until the streams have passed them.

    imu, table: the end of each stream, as much as a segment that is still to be checked needs, in
    the pieces it came in: a long segment of a fast unit is joined once.
    """

    def __init__(self, link: UnitLink) -> None:
        self.imu: list[Stream] = []
        self.table: list[Stream] = []
        self._link = link
        self._waiting: list[tuple[Segment, str | None]] = []

    def add(self, segment: Segment, spin_axis: str | None) -> None:
        """Check this segment once its data are there; `spin_axis` is the table axis turning."""
        self._waiting.append((segment, spin_axis))

    @property
    def reached_s(self) -> float:
        """The time up to which both streams have come."""
        return min(each[-1].t[-1] if each else -np.inf for each in (self.imu, self.table))

    def run(self, imu: Stream, table: Stream, half_width_s: float) -> list[Anomaly]:
        """Take in what came next, and check every segment whose data are there.

        half_width_s: by how much the time of an angle of the table may be wrong.
        """
        self.imu += [imu] if len(imu) else []
        self.table += [table] if len(table) else []
        anomalies = []
        while self._waiting and self.reached_s >= self._waiting[0][0].t_end:
            segment, spin_axis = self._waiting.pop(0)
            imu, table = joined(self.imu), joined(self.table)
            anomalies += check_unit(segment, imu, self._link)
            if spin_axis is not None:
                anomalies += check_rate(segment, spin_axis, table, half_width_s)
            self.imu = [imu.at(slice(_last_before(imu, segment.t_end), None))]
            self.table = [table.at(slice(_last_before(table, segment.t_end), None))]
        return anomalies


def _last_before(stream: Stream, t: float) -> int:
    """Where what is still needed of a stream begins; its last row stays in any case."""
    return min(int(np.searchsorted(stream.t, t)), len(stream) - 1)


def _anomaly(code: str, segment: Segment, subject: str, amount: float = 1.0) -> Anomaly:
    inside = (segment.t_start + segment.t_end) / 2
    return Anomaly(code, inside, inside, amount, subject)
