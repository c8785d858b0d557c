"""Work by a dask cluster: each thing once for the caller, whatever becomes of its workers."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from schemas.base import Unusable
from tasks.stages import on_cluster as cluster
from tasks.stages.on_cluster import on_cluster
from tests.tasks.stages.cluster_work import noted, squared, survived, waited

pytestmark = pytest.mark.real_time


@pytest.fixture
def started(tmp_path) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Starts a scheduler or a worker, which end with the test."""
    running: list[subprocess.Popen[bytes]] = []

    def start(*command: str) -> subprocess.Popen[bytes]:
        running.append(
            subprocess.Popen(
                [sys.executable, "-m", *command],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                cwd=Path.cwd(),
                start_new_session=True,
                env=os.environ | {"PYTHONPATH": str(Path.cwd())},
            )
        )
        return running[-1]

    yield start
    for process in running:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(60)


@pytest.fixture
def address() -> str:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return f"tcp://127.0.0.1:{free.getsockname()[1]}"


def scheduler(address: str) -> tuple[str, ...]:
    return "distributed.cli.dask_scheduler", "--host", address, "--no-dashboard"


def worker(address: str, folder: Path) -> tuple[str, ...]:
    return (
        "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard",
        "--local-directory", str(folder), "--death-timeout", "300",
    )  # fmt: skip


def test_a_killed_worker_and_a_restarted_scheduler_cost_no_result(
    started, address, tmp_path, monkeypatch
):
    monkeypatch.setattr(cluster, "ANSWER_S", 60.0)
    first = started(*scheduler(address))
    victim = started(*worker(address, tmp_path / "one"))
    started(*worker(address, tmp_path / "two"))
    things = [str(tmp_path / f"thing-{k}") for k in range(40)]
    done = []
    for result in on_cluster(noted, things, address, died=lambda thing: f"died at {thing}"):
        done.append(result)
        if len(done) == 5:
            victim.kill()
        if len(done) == 15:
            os.killpg(first.pid, signal.SIGKILL)
            first.wait(60)
            started(*scheduler(address))
            started(*worker(address, tmp_path / "three"))
    assert sorted(done) == sorted(things)


@pytest.mark.rehearsal
def test_a_thing_that_kills_workers_takes_none_of_its_batch_with_it(
    started, address, tmp_path, monkeypatch
):
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    started(*scheduler(address))
    started(*(part for part in worker(address, tmp_path / "one") if part != "--no-nanny"))
    done = list(on_cluster(survived, range(100), address, died=lambda thing: -thing))
    assert sorted(done) == sorted([-13, *range(13), *range(14, 100)])


def test_a_batch_that_takes_longer_than_expected_is_shared_again(monkeypatch):
    """A first recording that fails at once says nothing of how long the others take."""
    monkeypatch.setattr(cluster, "BATCH_S", 0.5)
    batches = cluster._Batches(range(100))
    assert next(batches) == [0]
    batches.measure(0.001, 3)
    batch = next(batches)
    assert len(batch) == 33
    seconds, done = cluster._each(waited, batch)
    assert len(done) < len(batch)
    assert seconds < 2.0 * cluster.BATCH_S
    batches.put_back(batch[len(done) :])
    assert next(batches)[0] == batch[len(done)]


def test_what_is_no_address_is_a_sentence_at_once():
    with pytest.raises(Unusable, match=r"--scheduler nonsense: .*tcp://HOST:PORT"):
        list(on_cluster(squared, [1], "nonsense", squared))


def test_a_computer_too_busy_for_a_thread_is_tried_again(address, monkeypatch):
    def client(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr(cluster, "Client", client)
    monkeypatch.setattr(cluster, "PATIENCE_S", 0.0)
    with pytest.raises(Unusable, match=r"--scheduler tcp://127\.0\.0\.1"):
        list(on_cluster(squared, [1, 2], address, died=squared))


def test_no_scheduler_is_a_sentence(address, monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER_S", 0.5)
    monkeypatch.setattr(cluster, "PATIENCE_S", 0.0)
    began = time.monotonic()
    with pytest.raises(Unusable, match=r"--scheduler tcp://127\.0\.0\.1"):
        list(on_cluster(squared, [1, 2], address, died=squared))
    assert time.monotonic() - began < 60.0


@pytest.mark.rehearsal
def test_a_worker_with_another_version_is_a_sentence(started, address, tmp_path, monkeypatch):
    (tmp_path / "tasks").mkdir()
    (tmp_path / "tasks" / "__init__.py").touch()
    (tmp_path / "tasks" / "version.py").write_text("def code_version(): return 'an old one'")
    started(*scheduler(address))
    monkeypatch.chdir(tmp_path)
    started(*worker(address, tmp_path / "one"))
    with pytest.raises(Unusable, match=r"its worker tcp://\S+ has an old one, not .*install this"):
        list(on_cluster(squared, [1, 2, 3], address, died=squared))


def test_no_worker_is_a_sentence(started, address, monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER_S", 60.0)
    monkeypatch.setattr(cluster, "PATIENCE_S", 1.0)
    started(*scheduler(address))
    with pytest.raises(Unusable, match=r"has no worker; start some with `dask worker tcp://"):
        list(on_cluster(squared, [1, 2, 3], address, died=squared))
