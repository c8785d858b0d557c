"""The README's picture, from a demonstration's home: the run, and two pages of its certificate.

`MIMUCAL_HOME=… python deploy/picture.py deploy/demo.png` after `mimucal demo`.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pypdfium2

from schemas.recording import ACCEL, AXES, GYRO
from storage.catalogue import certificates, runs
from storage.home import home

EVERY = 25  # rows: one in a quarter of a second
PAGES = (0, 2)


def main(target: Path) -> None:
    """Draw the newest certified run of the home."""
    mpl.use("Agg")
    entry = certificates.register(home())[-1]
    recording = runs.load(runs.find(entry.run, home()), home())
    figure = plt.figure(figsize=(15, 7.2), layout="constrained")
    left, *pages = figure.subfigures(1, 3, width_ratios=(1.25, 1, 1))
    run = left.subplots(3, 1, sharex=True)
    minutes = recording.imu.t[::EVERY] / 60
    for name, axis in zip(GYRO, AXES, strict=True):
        run[0].plot(minutes, np.degrees(recording.imu.columns[name][::EVERY]), lw=0.8, label=axis)
    for name, axis in zip(ACCEL, AXES, strict=True):
        run[1].plot(minutes, recording.imu.columns[name][::EVERY], lw=0.8, label=axis)
    air = recording.environment
    run[2].plot(minutes, recording.imu.columns["temperature"][::EVERY], label="unit", lw=0.8)
    run[2].plot(air.t / 60, air.columns["temperature"], label="chamber", lw=0.8)
    for axes, label in zip(run, ("gyro, °/s", "accelerometer, m/s²", "°C"), strict=True):
        axes.set_ylabel(label)
        axes.legend(loc="upper right", fontsize=8, ncols=3)
    run[0].set_title(
        f"{recording.manifest.recording_id}: one command, 38 minutes of station time", fontsize=10
    )
    run[2].set_xlabel("station time, minutes")
    document = pypdfium2.PdfDocument(home().path / entry.pdf)
    for page, place in zip(PAGES, pages, strict=True):
        axes = place.subplots()
        axes.imshow(document[page].render(scale=1.6).to_pil())
        axes.axis("off")
    figure.savefig(target, dpi=90, metadata={"Software": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
