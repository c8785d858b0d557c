"""How fast recordings are read from MCAP: this program beside the mcap package's own reader."""

import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from schemas.recording import ACCEL, FORMAT, GYRO, Manifest, Recording, Station, Stream, Unit
from storage.formats.mcap.messages import IMU_TOPIC
from storage.formats.mcap.reader import Bag, read_mcap
from storage.formats.mcap.writer import write_mcap
from tests.bench.measure import Figure, Section, processor_s

ASKED = 10.0  # times as fast as the package


def made(messages: int) -> Recording:
    """A recording at 1 kHz with readings in counts, as a MEMS unit gives them."""
    rng = np.random.default_rng(1)
    counts = {name: np.rint(300 * rng.normal(size=messages)) * 1e-4 for name in GYRO + ACCEL}
    unit = Unit(manufacturer="-", model="-", serial="-")
    manifest = Manifest(format=FORMAT, recording_id="bench", unit=unit, station=Station(id="-"))
    return Recording(manifest, Stream(np.arange(messages) * 1e-3, counts))


def raw_iteration(path: Path) -> int:
    """The mcap package's reader, messages left as bytes."""
    from mcap.reader import make_reader

    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())


def reading(messages: int = 500_000) -> Section:
    """One file, read by the mcap package and by this program; both check every CRC."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.mcap"
        made_s = processor_s(partial(_written, made(messages), path), runs=1)
        figures = (
            Figure("mcap package, messages left as bytes", processor_s(
                partial(raw_iteration, path), runs=1
            )),
            Figure("gathered as arrays", processor_s(lambda: Bag(path).topic(IMU_TOPIC))),
            Figure("`read_mcap`, checked, with digest", processor_s(
                partial(read_mcap, path)
            ), ASKED),
            Figure("written", made_s),
        )  # fmt: skip
    return Section(f"MCAP, {messages:,} messages of sensor_msgs/Imu", figures, faster=True)


def _written(recording: Recording, path: Path) -> None:
    path.unlink(missing_ok=True)
    write_mcap(recording, path)
