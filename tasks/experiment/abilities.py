"""What a station can do: its table's axes, rates and acceleration, and its chamber."""

from dataclasses import dataclass

import numpy as np

from schemas.base import Unusable
from schemas.limits import ChamberLimits
from schemas.recording import Mount, Recording, Station
from schemas.station import StationFile
from tasks.motion.whole import whole_motion

RATE_DEG_S, ACCELERATION_DEG_S2 = 90.0, 120.0  # of a station file that states no limit
SMOOTH_S = 0.1  # over which the encoders tell an acceleration
RARE = 99.5  # percentile of what the encoders tell: above it is their noise


@dataclass(frozen=True)
class Abilities:
    """A table and the unit on it.

    rates_deg_s: of each axis, outermost first. acceleration_deg_s2: of all. endless: of each axis,
    whether it turns on and on. chamber: None where its temperature cannot be set, or is not known
    to be.
    """

    station: Station
    mount: Mount
    rates_deg_s: tuple[float, ...]
    acceleration_deg_s2: float
    endless: tuple[bool, ...]
    chamber: ChamberLimits | None = None

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
            file.station, file.mount, rates, acceleration, endless, file.limits.chamber
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
        speeds = np.abs(np.degrees(axes.speeds))
        rates = np.nanmax(speeds, axis=0)
        rows = max(1, round(SMOOTH_S / float(np.median(np.diff(recording.imu.t)))))
        change = np.abs(speeds[rows:] - speeds[:-rows]) / SMOOTH_S
        ramps = change[change > 0.2 * np.nanmax(change)]
        acceleration = float(np.nanpercentile(ramps, RARE)) if len(ramps) else ACCELERATION_DEG_S2
        turned = np.ptp(np.nan_to_num(np.degrees(axes.angles)), axis=0)
        endless = tuple((turned > 720.0).tolist())
        return cls(
            manifest.station, manifest.mount, tuple(np.round(rates, 1).tolist()),
            round(acceleration, 1), endless,
        )  # fmt: skip

    @property
    def axis_count(self) -> int:
        return len(self.rates_deg_s)
