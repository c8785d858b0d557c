"""The stop that an operator presses once while a table turns."""

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from schemas.recording import RunStatus
from schemas.station import StationFile
from tasks.station.virtual.config import draw_unit
from tests.proof.factory.facts import Order
from tests.proof.factory.works import Works
from tests.proof.virtual_runs import comes_to_rest

WITHIN_S = 2.0  # from the press to the table's rest
FROM_SEGMENT = 5  # of a run: what was measured before is to be there when it goes on
MEASURING = "measuring"


@dataclass
class Stop:
    """Pressed at the first run that is well under way. answer: what the command answered."""

    works: Works
    station: str = ""
    order: str | None = None
    seconds: float | None = None
    is_at_rest: bool = False
    answer: str = ""

    @property
    def is_over(self) -> bool:
        return self.order is not None

    def tick(self, orders: list[Order], after: int) -> None:
        """after: orders that are to be done before."""
        done = sum(order.state == "done" for order in orders)
        running = [each for each in orders if each.state == "running" and not each.runs]
        for status in self._statuses() if not self.is_over and done >= after else ():
            mine = [each for each in running if each.serial in status.units]
            if mine and status.state == MEASURING and (status.segment or 0) >= FROM_SEGMENT:
                self.station = status.station
                self._press(mine[0])
                return

    def _statuses(self) -> Iterator[RunStatus]:
        for file in (self.works.home / "status").glob("*.json"):
            with suppress(OSError, ValueError):
                yield RunStatus.model_validate_json(file.read_bytes())

    def _press(self, order: Order) -> None:
        self.order = order.number
        try:
            answer = self.works.command("station", "stop", self.station, "--by", "Li Na", "--json")
        except RuntimeError as fault:
            self.answer = str(fault)
            return
        self.seconds = float(json.loads(answer)["seconds"])
        self.answer = answer.strip()
        station = StationFile.model_validate_json(
            self.works.station_file(self.station).read_bytes()
        )
        self.is_at_rest = comes_to_rest(station, draw_unit(1).gyro.lsb)
        self.works.command("station", "release", self.station)
