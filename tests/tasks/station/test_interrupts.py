"""An operator ends a run: the table comes to rest, and what was recorded is kept."""

import signal

import pytest

from tasks.station.progress import Progress
from tasks.station.virtual.config import VirtualStation
from tests.tasks.station.in_memory import InMemoryStation
from tests.tasks.station.in_thread import serving
from tests.tasks.station.over_sockets import MEASURED, SPEED, over_sockets, table_and_watchdog


@pytest.mark.real_time
def test_interrupt_stops_the_table_and_keeps_what_was_recorded(short, kept):
    def interrupt(progress: Progress) -> None:
        if progress.now.startswith("rate"):
            signal.raise_signal(signal.SIGINT)

    with serving(VirtualStation(), SPEED) as station:
        with pytest.raises(KeyboardInterrupt):
            over_sockets(station, short, kept, interrupt)
        state, watchdog = table_and_watchdog(station)
    assert [axis.rate_deg_s for axis in state.axes] == pytest.approx([0.0] * 3, abs=1e-6)
    assert watchdog == 0
    assert kept.measured() == MEASURED[:2]
    assert len(kept.stream("imu"))


def test_what_is_on_the_line_when_a_run_is_interrupted_is_kept(short, kept):
    def interrupt(progress: Progress) -> None:
        if progress.now.startswith("rate"):
            raise KeyboardInterrupt

    station = InMemoryStation(VirtualStation())
    with pytest.raises(KeyboardInterrupt):
        station.acquire(short, kept, interrupt)
    assert station.table.has_been_left
    assert kept.measured() == MEASURED[:2]
    assert kept.stream("imu").t[-1] >= kept.manifests[-1].segments[-1].t_end - 0.5
