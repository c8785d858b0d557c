"""One run on one station: a second is refused, and a dead one holds nothing."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from schemas.base import Unusable
from storage.home import Home
from storage.station_lock import one_run_on

HOLDER = (
    "import sys\n"
    "from pathlib import Path\n"
    "from storage.home import Home\n"
    "from storage.station_lock import one_run_on\n"
    "with one_run_on('T1', Home(Path(sys.argv[1]))):\n"
    "    print('held', flush=True)\n"
    "    sys.stdin.read()\n"
)


def test_a_second_run_is_refused_until_the_first_has_ended_even_by_kill(tmp_path: Path) -> None:
    home = Home(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as holder:  # fmt: skip
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        refused = pytest.raises(Unusable, match=rf"station T1 \(process {holder.pid}\)")
        with refused, one_run_on("T1", home):
            pass
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    with one_run_on("T1", home):
        pass


def test_stations_side_by_side_do_not_wait_for_each_other(tmp_path: Path) -> None:
    with one_run_on("T1", Home(tmp_path)), one_run_on("T2", Home(tmp_path)):
        assert len(list((tmp_path / "locks").iterdir())) == 2
