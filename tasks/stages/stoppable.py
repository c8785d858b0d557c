"""A station locked for a run that anybody can stop, even if the run's own thread is busy."""

import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from schemas.station import StationFile, StopAnswer, StopRequest
from storage.home import Home
from storage.stations import (
    answer_stop,
    end_status,
    keep_station_file,
    one_run_on,
    request_in,
    share_status,
    take_back,
)
from tasks.station.connected_station import StopSwitch, axes_of, stopped_by
from tasks.words import statement

LOOK_S = 0.1  # between two looks for a request
SHARE_S = 1.0  # between two statuses for other computers
LEAVE_S = 2.0  # how long the end of a run waits for a home on the network


@contextmanager
def stop_watch(station: StationFile, home: Home, stop: StopSwitch) -> Iterator[None]:
    """The station for the length of the block; a request to stop it presses the switch.

    Two threads look for requests: one beside the lock, and one in the home where that is another
    folder, for a home on the network may not answer. Raises Unusable as `one_run_on` does.
    """
    id_ = station.station.id
    with one_run_on(id_, home):
        take_back(home.locks, id_)
        keep_station_file(station, home)
        watches = [_Watch(station, home, home.locks, stop, lambda: None)]
        if home.shared_locks != home.locks:
            watches.append(
                _Watch(station, home, home.shared_locks, stop, lambda: share_status(id_, home))
            )
        for each in watches:
            each.start()
        try:
            yield
        finally:
            for each in watches:
                each.end()


class _Watch(threading.Thread):
    """Looks for a request in one folder, presses the switch, and answers.

    share: called about every SHARE_S, and at the end.
    """

    def __init__(
        self, station: StationFile, home: Home, folder: Path, stop: StopSwitch,
        share: Callable[[], None],
    ) -> None:  # fmt: skip
        super().__init__(name="stop", daemon=True)
        self._station, self._home, self._folder, self._switch = station, home, folder, stop
        self._share, self._shared_s = share, 0.0
        self._old: StopRequest | None = None
        self._is_over = threading.Event()

    def run(self) -> None:
        self._old = request_in(self._folder, self._station.station.id)
        while not self._is_over.wait(LOOK_S):
            self._look()
        self._look()
        self._shared_s = 0.0
        self._share_sometimes()

    def end(self) -> None:
        """Look a last time, and no more."""
        self._is_over.set()
        self.join(LEAVE_S)

    def _look(self) -> None:
        request = request_in(self._folder, self._station.station.id)
        if request is not None and request != self._old:
            self._old = request
            self._switch.press(request.by)
            self._answer(request)
            take_back(self._folder, request.station)
        self._share_sometimes()

    def _answer(self, request: StopRequest) -> None:
        """That every axis was commanded to stop, then that the table is at rest."""
        answer = StopAnswer(key=request.key, process=os.getpid())
        if not self._wait(lambda: self._switch.is_commanded):
            return
        answer_stop(answer, self._folder, request.station)
        at_rest = self._wait(lambda: self._switch.rest is not None)
        read = {"at_rest": at_rest, "axes": axes_of(self._station, self._switch.rest)}
        # also if the run itself hangs: its last status would be wrong
        shown = statement(stopped_by(request.by))
        end_status(request.station, f"stopped by {request.by}", self._home, shown)
        answer_stop(answer.model_copy(update=read), self._folder, request.station)

    def _wait(self, is_so: Callable[[], bool]) -> bool:
        """Whether it becomes so before the run is over."""
        while not is_so():
            if self._is_over.wait(LOOK_S / 5):
                return is_so()
            self._share_sometimes()
        return True

    def _share_sometimes(self) -> None:
        if time.monotonic() - self._shared_s > SHARE_S:
            with suppress(OSError):
                self._share()
            self._shared_s = time.monotonic()
