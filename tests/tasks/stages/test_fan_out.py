"""Work on many things: each once, and a worker that dies costs only what it was at."""

import os
import signal
import time
from pathlib import Path

import pytest

from tasks.stages.fan_out import ONE_THREAD, fan_out


def squared(thing: int) -> int:
    return thing**2


def threads(thing: int) -> tuple[str | None, ...]:
    return tuple(os.environ.get(name) for name in ONE_THREAD)


def dies_once(thing: Path) -> str:
    """Kills its worker the first time."""
    if "mortal" in thing.name and not thing.exists():
        thing.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    with (thing.parent / "log").open("a") as log:
        log.write(thing.name + "\n")
    return thing.name


def dies_always(thing: str) -> str:
    if thing == "deadly":
        time.sleep(0.2)
        os.kill(os.getpid(), signal.SIGKILL)
    return thing


@pytest.mark.parametrize("workers", [1, 2])
def test_each_thing_is_done_once(workers):
    done = list(fan_out(squared, range(20), workers, died=lambda thing: -thing))
    assert sorted(done) == [k**2 for k in range(20)]


def test_workers_compute_with_one_thread_and_leave_the_environment_as_it_was(monkeypatch):
    monkeypatch.setenv(ONE_THREAD[0], "7")
    monkeypatch.delenv(ONE_THREAD[1], raising=False)
    assert set(fan_out(threads, [1, 2], 2, died=threads)) == {("1", "1", "1")}
    assert os.environ[ONE_THREAD[0]] == "7"
    assert ONE_THREAD[1] not in os.environ


def test_a_killed_worker_costs_no_result(tmp_path):
    things = [tmp_path / name for name in ("a", "b", "mortal", "c", "d", "e", "f")]
    done = list(fan_out(dies_once, things, 2, died=lambda thing: f"died at {thing}"))
    assert sorted(done) == sorted(thing.name for thing in things)


def test_what_kills_every_worker_is_given_up_and_the_rest_done():
    things = ["a", "deadly", "b", "c"]
    done = list(fan_out(dies_always, things, 2, died=lambda thing: f"{thing} died"))
    assert sorted(done) == ["a", "b", "c", "deadly died"]
