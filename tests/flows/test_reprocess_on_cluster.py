"""History made again by a cluster from a bucket: bit for bit what this machine makes, once."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from flows import execute
from schemas.orders import ReprocessOrder
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages import on_cluster
from tests.storage.s3_server import Store, serving

pytestmark = [pytest.mark.real_time, pytest.mark.rehearsal]


@pytest.fixture
def bucket(monkeypatch) -> Iterator[Store]:
    """A bucket that now and then answers 500, as MIMUCAL_STORE."""
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "of-a-test")
    store = Store(every=11)
    with serving(store) as url:
        monkeypatch.setenv("MIMUCAL_STORE", url)
        yield store


@pytest.fixture
def scheduler(home, bucket, tmp_path, request) -> Iterator[tuple[str, list[int]]]:
    """The address of a dask scheduler, and the process ids of as many workers."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    worker = (
        "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
        "--local-directory", str(tmp_path / "dask"), "--death-timeout", "300",
    )  # fmt: skip
    commands = [
        ("distributed.cli.dask_scheduler", "--host", address, "--no-dashboard"),
        *[worker] * request.param,
    ]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    environment = os.environ | {"PYTHONPATH": str(Path.cwd())}
    started = [
        subprocess.Popen([sys.executable, "-m", *each], env=environment, **quiet)
        for each in commands
    ]
    yield address, [process.pid for process in started[1:]]
    for process in started:
        process.kill()
        process.wait(60)


@pytest.mark.parametrize("scheduler", [2], indirect=True)
def test_a_cluster_makes_the_same_results_though_a_worker_is_killed(
    home, scheduler, bucket, ideal_run, monkeypatch
):
    monkeypatch.setattr(on_cluster, "ANSWER_S", 2.0)
    address, workers = scheduler
    store = Home(home)
    for k in range(4):
        runs.add(ideal_run(dwell=1.0, Kg=(1.0 + 0.01 * k) * np.eye(3)), store)
    local = execute.reprocess(ReprocessOrder(workers=1))
    assert (local.done, local.failed) == (4, 0)
    expected = {run.id: results.of_run(run, store)[0] for run in runs.all_runs(store)}
    (home / "catalog.sqlite").rename(home / "local.sqlite")
    for k in range(4):
        runs.add(ideal_run(dwell=1.0, Kg=(1.0 + 0.01 * k) * np.eye(3)), store)

    def killing(done: int, total: int) -> None:
        if done == 2:
            os.kill(workers[0], signal.SIGKILL)

    order = ReprocessOrder(engine="dask", scheduler=address)
    report = execute.reprocess(order, killing)
    assert (report.done, report.failed) == (4, 0), report.failures
    for run in runs.all_runs(store):
        (made,) = results.of_run(run, store)  # and nothing twice
        assert (made.id, made.calibration) == (expected[run.id].id, expected[run.id].calibration)
    assert bucket.faults > 2


@pytest.mark.parametrize("scheduler", [1], indirect=True)
def test_a_worker_on_another_store_makes_nothing(home, scheduler, ideal_run, monkeypatch):
    runs.add(ideal_run(dwell=1.0), Home(home))
    monkeypatch.setenv("MIMUCAL_STORE", os.environ["MIMUCAL_STORE"].replace("/mimu?", "/other?"))
    report = execute.reprocess(ReprocessOrder(engine="dask", scheduler=scheduler[0]))
    assert (report.done, report.failed) == (0, 1)
    assert "same MIMUCAL_DATABASE and MIMUCAL_STORE" in report.failures[0].why
