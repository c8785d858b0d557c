"""What happens to a cluster while it makes history again, each in its turn."""

import threading
from collections.abc import Callable

import sqlalchemy as sql

from schemas.base import Unusable
from storage.catalogue import database, tables
from storage.home import Home
from tests.proof.history.cluster import Cluster, catalogue

OFF_S = 3.0  # for which the database is away


class Disturbances:
    """Kills and restarts at parts of the work; `tick` is called about every second."""

    def __init__(self, cluster: Cluster, home: Home, total: int) -> None:
        self._cluster = cluster
        self._home = home
        self.happened: list[str] = []
        whats: tuple[tuple[str, Callable[[], None]], ...] = (
            ("worker killed", cluster.kill_worker),
            ("database restarted", self._restart_database),
            ("scheduler killed and restarted", cluster.kill_scheduler),
        )
        self._left = [(total * (k + 1) // 5, *what) for k, what in enumerate(whats)]
        self._timers: list[threading.Timer] = []

    def tick(self) -> None:
        """Lets the next thing happen where enough is done, and starts again what ended."""
        self._cluster.keep_up()
        if self._left and not any(timer.is_alive() for timer in self._timers):
            at, name, happens = self._left[0]
            if self._done() >= at:
                self.happened.append(f"{name} after {self._done()}")
                happens()
                del self._left[0]

    def _restart_database(self) -> None:
        self._cluster.database.stop()
        self._timers.append(threading.Timer(OFF_S, self._cluster.database.start))
        self._timers[-1].start()

    def _done(self) -> int:
        try:
            with catalogue(self._cluster.url):
                asked = sql.select(sql.func.count()).select_from(tables.results)
                return int(database.rows(self._home, asked)[0][0])
        except Unusable:
            return 0
