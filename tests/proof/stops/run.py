"""Many presses, and the page of them."""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

from tasks.station.virtual.config import VirtualStation
from tests.proof.report import table
from tests.proof.stops.station_run import preload, station_apart
from tests.proof.stops.stop import BOUND_S, RAMP_S, WATCHDOG_S, Pressed, press

AT_ONCE = 4
PAGE = "stops.md"
SPEEDS = (1.0, 5.0, 2.0, 20.0)  # of the stations, which take turns
RESUMED_EVERY = 8  # stops, after one of which it is tried whether the run goes on
COLUMNS = (
    "seed", "by", "down", "clock", "turning", "at rest (s)", "confirmed (s)", "went on", "wrong",
)  # fmt: skip


def run_all(folder: Path, count: int, report: Callable[[int, int], None]) -> list[Pressed]:
    """Presses of the seeds 1 to count, and stops.md, in a new folder."""
    pressed: list[Pressed] = []
    preload()
    with ProcessPoolExecutor(AT_ONCE, mp_context=get_context("fork")) as pool:
        begun = [pool.submit(_one, seed, folder / f"{seed:03d}") for seed in range(1, count + 1)]
        for done in as_completed(begun):
            pressed.append(done.result())
            report(len(pressed), count)
            (folder / PAGE).write_text(as_markdown(pressed), encoding="utf-8")
    return pressed


def _one(seed: int, folder: Path) -> Pressed:
    speed = SPEEDS[seed % len(SPEEDS)]
    config = VirtualStation(id=f"STOPS-{seed}")
    with station_apart(config, speed) as station:
        return press(
            seed, folder, station, speed, config.unit.gyro.lsb, resume=seed % RESUMED_EVERY == 3
        )


def summary(pressed: Sequence[Pressed]) -> str:
    """One sentence."""
    wrong = sum(bool(each.faults) or each.resumed is False for each in pressed)
    stopped = [each.rest_s for each in pressed if each.way != "kill -9"]
    killed = [each.rest_s for each in pressed if each.way == "kill -9"]
    again = [each.resumed for each in pressed if each.resumed is not None]
    turning = sum(each.turning for each in pressed)
    return (
        f"{len(pressed)} stops at random moments, {turning} of them with the table turning: "
        f"{wrong} wrong; the table was at rest at most {max(stopped, default=0.0):.2f} s after the "
        f"press, and at most {max(killed, default=0.0):.2f} s after the run's process was killed; "
        f"{sum(map(bool, again))} of the {len(again)} runs with which it was tried went on to "
        "their end"
    )


def as_markdown(pressed: Sequence[Pressed]) -> str:
    """The summary, how it was held, and a row for each press."""
    rows = [
        (
            each.seed, each.way, each.down, f"{each.speed:g}", "yes" if each.turning else "",
            f"{each.rest_s:.2f}", f"{each.confirmed_s:.2f}",
            {True: "yes", False: "NO", None: ""}[each.resumed], "; ".join(each.faults),
        )
        for each in sorted(pressed, key=lambda each: each.seed)
    ]  # fmt: skip
    return "\n".join([
        "# Stops",
        "",
        f"{summary(pressed)}.",
        "",
        "Each on a virtual station of its own, while a run turns its table at up to 300 °/s. The",
        "station is pressed to stop by a command in a process of its own, by the function behind",
        "the button of the pages, on the station's own page, by signals, or its run is killed; at",
        "that moment nothing is down, or the home or the database is renamed away, Prefect's",
        "address leads nowhere, or the run's own event loop hangs. Whether the table turns is read",
        "from the gyros of its unit (wall time; below 2 °/s is at rest), and must be over within",
        f"{BOUND_S:g} s, or after a kill within the watchdog's {WATCHDOG_S:g} s and a ramp of at",
        f"most {RAMP_S:g} s. Clock 1 is real time: the ramps are those of a table that brakes with",
        "400 °/s² at a quick stop; at clock 5 and 20 they are shorter by that factor. Afterwards a",
        "recording is left and can be read, no lock or request is left, and no status says that",
        f"anything runs. After one in {RESUMED_EVERY} stops the run goes on to its end.",
        "",
        *table(COLUMNS, rows),
        "",
    ])  # fmt: skip
