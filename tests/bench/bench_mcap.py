"""How fast recordings are read from MCAP: this program beside the mcap package's own reader.

Run from the repository root: `python tests/bench/bench_mcap.py [messages]`.
"""

import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from schemas.recording import ACCEL, FORMAT, GYRO, Manifest, Recording, Station, Stream, Unit
from storage.formats.mcap.bag import Bag
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.topics import IMU_TOPIC
from storage.formats.mcap.writer import write_mcap


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


def decoded_iteration(path: Path) -> int:
    """The mcap package's reader with its ROS 2 decoder."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return sum(1 for _ in reader.iter_decoded_messages())


def best(read: Callable[[], int], runs: int) -> float:
    """Messages per second of the best of some runs."""
    rates = []
    for _ in range(runs):
        start = time.perf_counter()
        count = read()
        rates.append(count / (time.perf_counter() - start))
    return max(rates)


def main(messages: int = 500_000) -> None:
    """Prints messages per second and ratios for one generated file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bench.mcap"
        recording = made(messages)
        start = time.perf_counter()
        write_mcap(recording, path)
        written = messages / (time.perf_counter() - start)
        size = path.stat().st_size / messages
        rates = {
            "write_mcap": written,
            "gathered as arrays": best(lambda: len(Bag(path).topic(IMU_TOPIC).stamps), runs=5),
            "read_mcap (checked, with digest)": best(lambda: len(read_mcap(path).imu), runs=5),
            "mcap package, raw": best(lambda: raw_iteration(path), runs=1),
        }
        if find_spec("mcap_ros2"):
            rates["mcap package, decoded"] = best(lambda: decoded_iteration(path), runs=1)
    print(f"{messages} sensor_msgs/msg/Imu, {size:.0f} bytes each on disk")
    for name, rate in rates.items():
        times = rate / rates["mcap package, raw"]
        print(f"{name:34} {rate / 1e6:7.3f} M messages/s   {times:6.1f} × mcap package, raw")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:]))
