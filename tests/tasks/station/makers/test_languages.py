"""Two languages of rate tables, driven by their sample station files alone."""

import os
import re
import select
import socketserver
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.register import BY_STANDARD
from tasks.station import procedures
from tasks.station.check_devices import check_station
from tasks.station.virtual.config import TableDesign, truth, virtual_station
from tasks.station.virtual.table import VirtualTable
from tests.proof.station import shortened
from tests.tasks.station.makers.modbus_maker import listening
from tests.tasks.station.makers.simulated_text import (
    Axes,
    ColonMaker,
    Controller,
    EmulatedStation,
    LettersMaker,
    Line,
)
from tests.tasks.station.makers.text_maker import thermometer
from tests.tasks.station.sample_stations import sample

Make = Callable[[Axes, Callable[[], float]], Controller]
NEEDS_S = 0.2  # between two commands of the one with colons
MAKERS: dict[str, Make] = {
    "scpi_table": lambda axes, now: ColonMaker(axes, now, NEEDS_S),
    "three_letter_table": lambda axes, now: LettersMaker(axes),
}
BAUDRATES = {"scpi_table": 0, "three_letter_table": 9600}
languages = pytest.mark.parametrize("language", MAKERS)


def station(language: str, make: Make | None = None, **line: Any) -> EmulatedStation:
    config, behind = virtual_station(3, ahrs=False), Line(BAUDRATES[language], **line)
    return EmulatedStation(config, sample(language)["table"], make or MAKERS[language], behind)


def within_U(emulated: EmulatedStation, recording: Any) -> None:  # noqa: N802 (the symbol)
    """Every element of both matrices, and the biases of the accelerometers, lies within its U."""
    made = calibrate(BY_STANDARD[recording.manifest.standard], recording, run="r", code_version="c")
    true = truth(emulated.simulation.config)
    for triad, name in (("gyro", "Kg"), ("accel", "Ka")):
        matrix = np.array(true[name])
        for item, off_diagonal in ((f"{triad}_scale_factor", False),
                                   (f"{triad}_cross_coupling", True)):  # fmt: skip
            found = made.items[item]
            for element, value in found.value.items():
                i, j = ("xyz".index(axis) for axis in (element if off_diagonal else element * 2))
                off = value - matrix[i, j]
                assert abs(off) < 1.5 * found.U[element], (item, element, off, found.U[element])
        assert max(made.items[f"{triad}_scale_factor"].U.values()) < 2e-4


def run_of(emulated: EmulatedStation, procedure: Procedure, sink: Any, points: int) -> None:
    run = emulated.acquire(procedure, sink)
    assert emulated.controller.refused == []
    assert not emulated.simulation.table.rate.any()
    measured = [each for each in run.manifest.segments or () if each.kind in ("static", "rate")]
    assert len(measured) == points
    assert run.lost_samples == run.bad_frames == 0


@pytest.mark.parametrize(
    "language", ["three_letter_table", pytest.param("scpi_table", marks=pytest.mark.rehearsal)]
)
def test_a_procedure_runs_with_late_and_lost_answers_and_a_busy_computer(language, short, kept):
    """A tenth of the answers is lost, so that a short run meets some."""
    run_of(station(language, lost=0.1, busy=0.05), short, kept, 4)


@pytest.mark.rehearsal
@languages
@pytest.mark.parametrize("of", [shortened, procedures.load])
def test_jjf_2003_runs_with_late_and_lost_answers_and_its_values_hold(language, of, tmp_path):
    emulated = station(language, lost=0.001, busy=0.005)
    with RawWriter(tmp_path / "run.mcap") as sink:
        run_of(emulated, of("jjf2003"), sink, 48)
    within_U(emulated, read_mcap(tmp_path / "run.mcap"))


class Faulty:
    """A controller that from a line on answers it wrongly, and does it or not."""

    def __init__(self, controller: Controller, line: str, answer: bytes, does_it: bool) -> None:
        self.terminator, self._inside = controller.terminator, controller
        self._line, self._answer, self._does_it = re.compile(line), answer, does_it
        self.is_on = True

    def hear(self, line: bytes) -> bytes:
        if not self._line.search(line.decode()):
            return self._inside.hear(line)
        if self._does_it:
            self._inside.hear(line)
        return self._answer


LETTERS = ["SRV A 1", "HOM B", "ACL", "VEL A", "PPO A", "JOG", "STO"]
ASKED = ["PPO\\? A", "VEL\\? B", "STA\\? C"]
WRONG = {"error": b"?07\r\n>", "noise": b"\x00\xff>", "none": b""}
# Half of them in turn in `make test`, so that each line meets each answer; all in a rehearsal.
LATE = ("JOG", "STO")  # they come when most of the run is over
FAULTY = [
    pytest.param(
        line, answer, does_it, id=f"{line}-{name}-{'does it' if does_it else 'does not'}",
        marks=() if does_it == (row + column) % 2 and (line not in LATE or column == 1)
        else pytest.mark.rehearsal,
    )
    for row, line in enumerate(LETTERS + ASKED)
    for column, (name, answer) in enumerate(WRONG.items())
    for does_it in (True, False)
]  # fmt: skip


@pytest.mark.parametrize(("line", "answer", "does_it"), FAULTY)
def test_a_wrong_answer_is_one_sentence_and_a_table_at_rest(short, kept, line, answer, does_it):
    emulated = station(
        "three_letter_table", lambda axes, now: Faulty(LettersMaker(axes), line, answer, does_it)
    )
    if (line, answer, does_it) == ("STO", b"", True):  # a stop that is repeated is a stop
        pytest.skip("it is asked again, and stops each time")
    with pytest.raises(Unusable) as stopped:
        emulated.acquire(short, kept)
    sentence = str(stopped.value)
    assert line.replace("\\", "").split()[0] in sentence
    assert "\n" not in sentence
    assert not emulated.simulation.table.rate.any()


COLONS = [
    ":int:close 2", ":mode:pos", ":lim:acc pos", ":lim:rate pos", ":dem:pos 3",
    *(pytest.param(one, marks=pytest.mark.rehearsal) for one in (":mode:rate", ":dem:rate 1,-50")),
]  # fmt: skip


@pytest.mark.parametrize("line", COLONS)
def test_a_silent_command_that_was_not_taken_is_one_sentence_and_a_table_at_rest(short, kept, line):
    class Refuses(ColonMaker):
        def _commanded(self, text: str) -> None:
            if text.startswith(line):
                raise ValueError(text)
            super()._commanded(text)

    emulated = station("scpi_table", lambda axes, now: Refuses(axes, now, NEEDS_S))
    with pytest.raises(Unusable, match=r"“\*esr\?” with “32” instead of “0”") as stopped:
        emulated.acquire(short, kept)
    assert line in str(stopped.value)
    assert not emulated.simulation.table.rate.any()


def test_a_command_that_comes_too_soon_is_lost_and_that_is_said(short, kept):
    emulated = station("scpi_table", lambda axes, now: ColonMaker(axes, now, 0.5))
    with pytest.raises(Unusable, match=r"“\*esr\?” with “16”"):
        emulated.acquire(short, kept)


NEEDS_WALL_S = 0.1  # a busy machine reads a line late


SWING = {
    "kind": "oscillation", "name": "sine_x", "item": "decide", "axis": "x", "up": "+x",
    "spin_axis": 0, "amplitude_deg": 5.0, "frequency_hz": 0.5, "cycles": 4,
}  # fmt: skip


def with_a_swing(short: Procedure) -> Procedure:
    values = short.model_dump()
    swing = SWING | {"angles_deg": values["steps"][2]["angles_deg"]}
    return Procedure.model_validate(values | {"steps": [*values["steps"], swing]})


def test_a_controller_that_has_sinusoids_makes_them_and_the_encoders_show_it(short, kept):
    emulated = station("three_letter_table")
    run = emulated.acquire(with_a_swing(short), kept)
    (swung,) = [each for each in run.manifest.segments or () if each.name.startswith("sine_x")]
    assert swung.kind == "transition"
    table = kept.stream("table")
    angle = np.degrees(table.columns["outer_angle"][table.rows(swung.t_start, swung.t_end)])
    assert 7.0 < np.ptp(angle) < 11.0  # of polled angles the extremes may be missed
    assert not emulated.simulation.table.rate.any()


def test_a_controller_that_has_none_is_told_before_anything_moves(short, kept):
    emulated = station("scpi_table")
    with pytest.raises(Unusable, match=r"step sine_x .* the table has no command oscillate"):
        emulated.acquire(with_a_swing(short), kept)
    assert emulated.simulation.table.steps == 0


def test_a_swing_beyond_the_limits_is_refused():
    from tasks.station.plan import check_limits

    fields = sample("three_letter_table")
    fields["limits"] = {"axes": {"outer": {"acceleration_deg_s2": 500.0, "angle_deg": [-4, 400]}}}
    procedure = with_a_swing(shortened("jjf2003"))
    only = procedure.model_copy(update={"steps": procedure.steps[-1:]})
    with pytest.raises(Unusable, match=r"segment sine_x .* needs -5 deg"):
        check_limits(only, StationFile.model_validate(fields))


def test_whole_turns_are_refused_where_it_goes_to_angles_of_one_turn_alone(kept):
    values = procedures.load("jjf2003").model_dump()
    same = ("name", "item", "axis", "up", "spin_axis")
    turns = {name: SWING[name] for name in same} | {"kind": "turns", "turns": 2}
    turns |= {"rate_deg_s": 50.0, "angles_deg": values["steps"][0]["angles_deg"]}
    procedure = Procedure.model_validate(values | {"steps": [turns]})
    with pytest.raises(Unusable, match="whole turns, and move_to of the table takes angles within"):
        station("scpi_table").acquire(procedure, kept)


class InWallTime:
    """A controller whose table turns in wall time, asked by several connections."""

    def __init__(self, make: Make) -> None:
        self.table = VirtualTable(TableDesign())
        self.controller = make(Axes(self.table), lambda: self.table.now)
        self.terminator = self.controller.terminator
        self._began_s, self._alone = time.monotonic(), threading.Lock()

    def hear(self, line: bytes) -> bytes:
        with self._alone:
            behind = int((time.monotonic() - self._began_s) * 1000) - self.table.steps
            if behind > 0:
                self.table.advance(behind)
            return self.controller.hear(line)


@contextmanager
def over_tcp(controller: InWallTime) -> Iterator[str]:
    class Connection(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            waiting = b""
            while received := self.request.recv(1000):
                *lines, waiting = (waiting + received).split(controller.terminator)
                for each in lines:
                    self.request.sendall(controller.hear(each))

    server = listening(Connection)
    try:
        yield f"socket://127.0.0.1:{server.server_address[1]}"
    finally:
        server.shutdown()
        server.server_close()


@contextmanager
def over_serial(controller: InWallTime) -> Iterator[str]:
    import tty

    near, far = os.openpty()
    tty.setraw(near)
    tty.setraw(far)
    ended, end = os.pipe()

    def serve() -> None:
        waiting = b""
        while ended not in select.select([near, ended], [], [])[0]:
            *lines, waiting = (waiting + os.read(near, 300)).split(controller.terminator)
            for each in lines:
                os.write(near, controller.hear(each))

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield os.ttyname(far)
    finally:
        os.write(end, b"x")
        thread.join()
        for each in (far, near, ended, end):
            os.close(each)


@pytest.mark.real_time
@pytest.mark.parametrize(
    ("language", "line", "changes"),
    [
        ("scpi_table", over_serial, {}),
        pytest.param(
            "scpi_table",
            over_tcp,
            {"answer_header": 8, "errors": None, "acknowledge": "{rest:t}"},
            marks=pytest.mark.rehearsal,
        ),
        ("three_letter_table", over_tcp, {}),
    ],
    ids=["colons serial", "colons with a header", "letters tcp"],
)
def test_a_small_move_over_a_real_line_comes_back(language, line, changes):
    header = "ACL 0001" if "answer_header" in changes else ""

    def make(axes: Axes, now: Callable[[], float]) -> Controller:
        if language == "scpi_table":
            return ColonMaker(axes, now, NEEDS_WALL_S, header)
        return LettersMaker(axes)

    controller, fields, air = InWallTime(make), sample(language), thermometer()
    with line(controller) as url:
        fields["table"] |= {"url": url, **changes}
        fields["chamber"]["url"] = f"socket://127.0.0.1:{air.server_address[1]}"
        fields["unit_link"]["url"] = "socket://127.0.0.1:1"
        trials = check_station(StationFile.model_validate(fields), move=True)
    air.shutdown()
    air.server_close()
    failed = [each for each in trials if not each.works]
    assert [each.device for each in failed] == ["unit"], failed
    assert controller.controller.refused == []
    assert np.abs(np.degrees(controller.table.angle)).max() < 0.01
