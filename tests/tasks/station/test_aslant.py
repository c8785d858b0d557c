"""A unit that is turned about none of its axes: acquired, labelled, and refused where half said."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from schemas.procedure import RateRun
from schemas.recording import GYRO
from tasks.motion.whole import whole_motion
from tasks.station.requirements import check_procedure
from tasks.station.virtual.config import VirtualStation
from tests.tasks.station.in_memory import InMemoryStation

RATE = 60.0
ASLANT = RateRun(
    name="aslant", item="decide", spin_axis=0, angles_deg=(0, 45, 0), rates_deg_s=(RATE,),
    dwell_s=2.0,
)  # fmt: skip


def test_a_unit_is_turned_aslant_and_its_label_names_the_axis_of_the_table(short, kept):
    station = InMemoryStation(VirtualStation())
    aslant = short.model_copy(update={"steps": (*short.steps[:1], ASLANT)})
    check_procedure(aslant, station.file)
    station.acquire(aslant, kept)
    segment = next(s for s in kept.manifests[-1].segments if s.name == "aslant_+60")
    assert (segment.kind, segment.axis, segment.up, segment.table_axis) == ("rate", None, None, 0)
    imu = kept.stream("imu")
    rates = imu.stack(GYRO)[imu.rows(segment.t_start, segment.t_end)]
    turned = np.sort(np.abs(np.degrees(rates.mean(axis=0))))
    assert turned == pytest.approx([0.0, RATE / 2**0.5, RATE / 2**0.5], abs=0.5)


def test_an_axis_without_the_one_that_is_up_is_refused():
    with pytest.raises(ValidationError, match="rate_run aslant has axis alone; give axis and up"):
        RateRun.model_validate(ASLANT.model_dump() | {"axis": "x"})


def test_labels_alone_do_not_say_how_a_unit_held_aslant_moves(ideal_run):
    recording = ideal_run(dwell=1.0)
    labels = recording.manifest.segments
    spin = next(k for k, s in enumerate(labels) if s.kind == "rate")
    changed = labels[spin].model_copy(update={"axis": None, "up": None, "table_axis": 0})
    manifest = recording.manifest.model_copy(
        update={"segments": (*labels[:spin], changed, *labels[spin + 1 :])}
    )
    without = replace(recording, manifest=manifest, table=None)
    rows = recording.imu.rows(changed.t_start, changed.t_end)
    assert np.isnan(whole_motion(without).rate[rows]).all()
    assert np.isfinite(whole_motion(replace(recording, table=None)).rate[rows]).all()
