"""The same history made again by a cluster, undisturbed and disturbed."""

from dataclasses import dataclass
from pathlib import Path

from storage.home import Home
from tests.proof.history import cluster
from tests.proof.history.cluster import catalogue, kept_results
from tests.proof.history.disturb import Disturbances
from tests.proof.history.local import Again, measured

EVERY, PAUSE_S = 9, 0.05  # of the disturbed bucket: a request in nine gets 500, each waits


@dataclass(frozen=True)
class Shared:
    """What a cluster took, how many results are those of this machine, and how many are twice."""

    again: Again
    identical: int
    twice: int
    happened: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether everything is done, bit for bit as here, and nothing twice."""
        done = self.again.done == self.identical and not self.again.failed
        return done and not self.twice


def made(source: Home, folder: Path, count: int, disturbed: bool = False) -> Shared:
    """Has a cluster make the first runs of a home again, whose results are there already.

    Raises RuntimeError with what the command said where it fails.
    """
    home = Home(folder)
    bucket = (EVERY, PAUSE_S) if disturbed else (0, 0.0)
    with cluster.running(home, source.path, *bucket) as of:
        cluster.copy_runs(source, of.url, count)
        disturb = Disturbances(of, home, count)
        again = measured(
            ("--engine", "dask", "--scheduler", of.address),
            of.variables,
            disturb.tick if disturbed else None,
        )
        with catalogue(of.url):
            kept = kept_results(home)
    expected = kept_results(source)
    return Shared(
        again,
        identical=sum(each[:1] == expected[run][:1] for run, each in kept.items()),
        twice=sum(len(each) > 1 for each in kept.values()),
        happened=tuple(disturb.happened),
    )
