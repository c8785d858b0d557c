"""What a station can do: its table's axes, rates and acceleration, and its chamber."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.limits import ChamberLimits
from schemas.recording import Mount, Recording, Station
from schemas.station import StationFile
from tasks.motion.samples import sample_interval
from tasks.motion.whole import TableAxes, whole_motion
from tasks.readings.standing import runs

RATE_DEG_S, ACCELERATION_DEG_S2 = 90.0, 120.0  # of a station file that states no limit
SMOOTH_S = 0.1  # over which the encoders tell an acceleration
RARE = 99.5  # percentile of what the encoders tell: above it is their noise
FAINT = 0.2  # of the largest acceleration: below it no axis changes its speed


@dataclass(frozen=True)
class Abilities:
    """A table and the unit on it.

    rates_deg_s: of each axis, outermost first. acceleration_deg_s2: of all. endless: of each axis,
    whether it turns on and on. chamber: None where its temperature cannot be set, or is not known
    to be. oscillates: whether the controller makes sinusoids. ramp_share: of the acceleration that
    ramps show: 1 where it is constant, ¾ where it comes and goes as sin².
    """

    station: Station
    mount: Mount
    rates_deg_s: tuple[float, ...]
    acceleration_deg_s2: float
    endless: tuple[bool, ...]
    chamber: ChamberLimits | None = None
    ramp_share: float = 1.0
    oscillates: bool = False

    @classmethod
    def of_station(cls, file: StationFile) -> "Abilities":
        """By the limits of a station file; of what it does not limit, what any table does."""
        names = [axis.name for axis in file.station.table_axes or ()]
        if not names:
            raise Unusable(
                f"the station file of {file.station.id} has no station.table_axes; "
                "list them, outermost first"
            )
        limits = {name: [each for _, each in file.limits.of(name)] for name in names}
        rates = tuple(
            min((one.rate_deg_s for one in limits[name] if one.rate_deg_s), default=RATE_DEG_S)
            for name in names
        )
        accelerations = [
            one.acceleration_deg_s2
            for name in names
            for one in limits[name]
            if one.acceleration_deg_s2
        ]
        endless = tuple(file.limits.is_endless(name) for name in names)
        acceleration = min(accelerations, default=ACCELERATION_DEG_S2)
        return cls(
            file.station, file.mount, rates, acceleration, endless, file.limits.chamber,
            oscillates="oscillate" in getattr(file.table, "commands", ()),
        )  # fmt: skip

    @classmethod
    def of_recording(cls, recording: Recording) -> "Abilities":
        """The abilities shown by the recording's own table; raises Unusable without encoders. No
        recording shows whether the station has a chamber.
        """
        manifest, axes = recording.manifest, whole_motion(recording).axes
        if axes is None:
            raise Unusable(
                f"{manifest.recording_id}: no table stream shows what its station can do; "
                "give the station file with --station FILE"
            )
        rates = np.nanmax(np.abs(np.degrees(axes.speeds)), axis=0)
        ramps = _ramps(recording, axes)
        shown = np.concatenate(ramps) if ramps else np.array([ACCELERATION_DEG_S2])
        acceleration = float(np.percentile(shown, RARE))
        turned = np.ptp(np.nan_to_num(np.degrees(axes.angles)), axis=0)
        endless = tuple((turned > 720.0).tolist())
        return cls(
            manifest.station, manifest.mount, tuple(np.round(rates, 1).tolist()),
            round(acceleration, 1), endless, ramp_share=_share(ramps),
        )  # fmt: skip

    def driven_as(self, recording: Recording) -> "Abilities":
        """With the ramps of a recording that its table made; as they are without encoders."""
        axes = whole_motion(recording).axes
        return self if axes is None else replace(self, ramp_share=_share(_ramps(recording, axes)))

    @property
    def axis_count(self) -> int:
        return len(self.rates_deg_s)


def _ramps(recording: Recording, axes: TableAxes) -> list[np.ndarray]:
    """(n,) deg/s² of an axis while it changes its speed, for each time that it does."""
    speeds = np.abs(np.degrees(axes.speeds))
    rows = max(1, round(SMOOTH_S / sample_interval(recording.imu.t)))
    change = np.nan_to_num(np.abs(speeds[rows:] - speeds[:-rows])) / SMOOTH_S
    changes = change > FAINT * change.max(initial=0.0)
    return [change[first:last, k] for k in range(change.shape[1])
            for first, last in runs(changes[:, k])]  # fmt: skip


def _share(ramps: Sequence[np.ndarray]) -> float:
    """Of the acceleration: ∫α²dt shows a lever arm, and share·limit·|Δω| is as large."""
    shares = [float(np.mean(ramp**2) / np.mean(ramp) / ramp.max()) for ramp in ramps]
    return float(np.median(shares)) if shares else 1.0
