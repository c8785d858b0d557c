"""The page for those who change the code, walked by a newcomer who copies what it says: every block
is written into a clone of the product, every command is run there and prints what the page says."""

import doctest
import json
import os
import re
import shutil
import socketserver
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

from schemas.recording import ACCEL, AXES, GYRO
from tests.tasks.station.makers.modbus_maker import Drive, listening

pytestmark = pytest.mark.rehearsal


GUIDE = Path("deploy/guide/how-to-add.md")
PRODUCT = ("flows", "tasks", "storage", "schemas")
PARTS = re.compile(
    r"^`(?P<path>[\w./-]+)`(?P<end>, at its end)?$|^```(?P<kind>\w+)\n(?P<block>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
EXPECTED = doctest.OutputChecker()
ELLIPSIS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MOST_S = 280.0  # of a command, on a busy machine
ROOT_OF_RATE = np.array([2e-3, -3e-3, 1e-3])  # of the unit that was recorded
GRAVITY, RATE_HZ, DWELL = 9.8, 50.0, 2.0
NOISE = np.repeat([1e-4, 1e-3], 3)  # of a sample, rad/s and m/s²

CERTIFICATE = """
from types import SimpleNamespace
from tasks.certificate.content import content
from tasks.certificate.dcc import dcc_of
from tests.drafts import certificate_of

print("CERTIFICATE")
certificate = certificate_of(SimpleNamespace(serial="1"), calibration)
print([section.title.id for section in content(certificate).sections])
print(dcc_of(certificate).decode())
"""
REPORT = """.venv/bin/python - <<'END'
from pathlib import Path
from tasks.explain.report import write_report
from tasks.model.term import effect_name
from tests.tasks.explain.report import made_report

found = made_report.finding(effect="lever_arm", title=effect_name("lever_arm"))
explained = made_report.explanation(found)
write_report(made_report.answer(explained), explained, Path("report"))
END
"""


class Clone:
    """A fresh clone of the product, in which a section of the guide is walked."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.ports = dict[str, str]()  # written in the guide, and listening here
        for name in PRODUCT:
            shutil.copytree(name, folder / name)
        (folder / ".venv" / "bin").mkdir(parents=True)
        for name, more in (("python", ""), ("mimucal", " -m flows.cli")):
            script = folder / ".venv" / "bin" / name
            script.write_text(f'#!/bin/sh\nexec "{sys.executable}"{more} "$@"\n', encoding="utf-8")
            script.chmod(0o755)

    def walk(self, heading: str, more: str = "") -> str:
        """What the commands of a section print, which touches as many files as the page says.

        more: Python that goes on in the process of the section's own, below a line of its own.
        """
        text = GUIDE.read_text(encoding="utf-8")
        section = text.split(f"\n## {heading}\n")[1].split("\n## ")[0]
        touched, printed, path, end = set[str](), "", "", ""
        for part in PARTS.finditer(section):
            kind, block = part["kind"], part["block"]
            if part["path"]:
                path, end = part["path"], part["end"]
            elif kind == "sh":
                printed = self.run(block.replace("\nEND\n", f"\n{more}\nEND\n"))
            elif kind == "text":
                own = re.split("^CERTIFICATE$", printed, flags=re.MULTILINE)[0]
                assert EXPECTED.check_output(block, own, ELLIPSIS), printed
            else:
                self._write(path, kind, block, bool(end))
                touched.add(path)
        (stated,) = re.findall(rf"\(#{heading.lower().replace(' ', '-')}\) \|([^|]*)\|", text)
        assert len(touched) == sum(map(int, re.findall(r"\d+", stated)))
        return printed

    def _write(self, path: str, kind: str, block: str, at_end: bool) -> None:
        file = self.folder / path
        if kind == "diff":
            lines = block.splitlines(keepends=True)
            before = "".join(line[1:] for line in lines if line[0] in " -")
            after = "".join(line[1:] for line in lines if line[0] in " +")
            text = file.read_text(encoding="utf-8")
            assert text.count(before) == 1, f"{path} has not once:\n{before}"
            file.write_text(text.replace(before, after), encoding="utf-8")
        elif at_end:
            file.write_text(file.read_text(encoding="utf-8") + block, encoding="utf-8")
        else:
            assert not file.exists(), f"{path} is there already"
            file.parent.mkdir(exist_ok=True)
            for written, meant in self.ports.items():
                block = block.replace(written, meant)
            file.write_text(block, encoding="utf-8")

            if file.name == "pyproject.toml":
                install(file.parent, self.folder)

    def run(self, command: str) -> str:
        """What a command prints, its errors among it."""
        paths = (self.folder, self.folder / "flows" / "python", self.folder / "bench", Path.cwd())
        own = {"PYTHONPATH": os.pathsep.join(map(str, paths)), "OPENBLAS_NUM_THREADS": "1"}
        own["MIMUCAL_HOME"] = str(self.folder / "home")
        done = subprocess.run(
            ["bash", "-ec", command], cwd=self.folder, env=os.environ | own, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=MOST_S,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout
        return done.stdout


class Table:
    """A table that takes words."""

    def __init__(self) -> None:
        self.drive, self.speed = Drive(), 1.0

    def answer(self, line: str) -> str:
        match line.split():
            case ["who"]:
                return "TOYTABLES T-1"
            case ["where", "A"]:
                return f"at {self.drive.angle:.4f}"
            case ["speed", "A"]:
                return f"at {self.drive.rate:.4f}"
            case ["fast", "A", speed]:
                self.speed = float(speed)
            case ["go", "A", angle]:
                self.drive.move(float(angle), self.speed)
            case ["halt", "A"]:
                self.drive.halt()
            case _:
                return "what?"
        return "ok"


@contextmanager
def bench() -> Iterator[dict[str, str]]:
    """The table and the unit of the guide's bench; the ports that they have in its place."""
    made = Table()

    class OfTable(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            waiting = b""
            while received := self.request.recv(1000):
                *lines, waiting = (waiting + received).split(b"\r")
                for line in lines:
                    self.request.sendall(made.answer(line.decode()).encode() + b"\n")

    class OfUnit(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            began_s, sent = time.monotonic(), 0
            with suppress(OSError):
                while True:  # 50 Hz, also where this thread is late
                    due = round(50 * (time.monotonic() - began_s))
                    self.request.sendall((due - sent) * b"IMU,0.001,0,0,0,0,9.79\n")
                    sent = due
                    time.sleep(0.02)

    servers = {":4001": listening(OfTable), ":4002": listening(OfUnit)}
    try:
        yield {name: f":{each.server_address[1]}" for name, each in servers.items()}
    finally:
        for each in servers.values():
            each.shutdown()
            each.server_close()


def install(project: Path, into: Path) -> None:
    """What pip writes of the entry points of a project."""
    declared = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    info = into / f"{declared['name'].replace('-', '_')}-{declared['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Name: {declared['name']}\nVersion: {declared['version']}\n")
    lines = [
        line for group, points in declared["entry-points"].items()
        for line in (f"[{group}]", *(f"{name} = {place}" for name, place in points.items()))
    ]  # fmt: skip
    (info / "entry_points.txt").write_text("\n".join(lines))


def readings() -> tuple[np.ndarray, list[dict[str, object]]]:
    """Six orientations, in each of them eight rates and a rest: values (n, 6), and the labels."""
    rng, count = np.random.default_rng(17), round(DWELL * RATE_HZ)
    rows, segments = [], []
    for axis in range(3):
        for sign, mark in ((1.0, "+"), (-1.0, "-")):
            for rate in (20.0, -20.0, 60.0, -60.0, 150.0, -150.0, 300.0, -300.0, 0.0):
                turning = np.radians(rate) * np.eye(3)[axis]
                gyro = turning + ROOT_OF_RATE * np.sqrt(np.abs(turning))
                reading = np.concatenate([gyro, sign * GRAVITY * np.eye(3)[axis]])
                start = DWELL * len(rows)
                rows.append(reading + NOISE * rng.standard_normal((count, 6)))
                segments.append({
                    "name": f"{mark}{AXES[axis]} {rate:+.0f}", "up": mark + AXES[axis],
                    "t_start": start, "t_end": start + DWELL,
                    **({"kind": "rate", "axis": AXES[axis], "rate_deg_s": rate} if rate
                       else {"kind": "static"}),
                })  # fmt: skip
    return np.concatenate(rows), segments


@pytest.fixture
def clone(tmp_path) -> Clone:
    made = Clone(tmp_path / "mimucal")
    values, segments = readings()
    folder = made.folder / "recording"
    folder.mkdir()
    manifest = {
        "format": "mimu-recording/1", "recording_id": "toy", "standard": "JJF 2003-2022",
        "unit": {"manufacturer": "test", "model": "m", "serial": "1"},
        "station": {"id": "TOY", "gravity_m_s2": GRAVITY}, "segments": segments,
        "streams": {"imu": "imu.csv"},
    }  # fmt: skip
    (folder / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    t = np.arange(len(values)) / RATE_HZ
    np.savetxt(
        folder / "imu.csv", np.column_stack([t, values]), fmt="%.9g", delimiter=",", comments="",
        header=",".join(("t", *GYRO, *ACCEL)),
    )  # fmt: skip
    return made


def test_an_effect_is_found_and_named_with_its_values(clone):
    printed = clone.walk("An effect")
    found = re.findall(r"coefficient_. (\S+) ± (\S+)", printed)
    for (value, u), true in zip(found, ROOT_OF_RATE, strict=True):
        assert abs(float(value) - true) < 4.0 * float(u)


def test_an_item_is_estimated_and_printed_from_its_record(clone):
    printed = clone.walk("An item", CERTIFICATE)
    values, segments = readings()
    means = values.reshape(len(segments), -1, 6).mean(axis=1)
    for channel, axis in enumerate(AXES):
        own = [i for i, each in enumerate(segments) if each.get("axis") == axis]
        rate = np.radians([float(str(segments[i]["rate_deg_s"])) for i in own])
        design = np.column_stack([rate, np.abs(rate), np.ones(len(own))])
        expected = np.linalg.lstsq(design, means[own, channel], rcond=None)[0][1]
        (row,) = re.findall(rf"gyro_scale_asymmetry +{axis} +(\S+) +(\S+)$", printed, re.MULTILINE)
        assert float(row[0]) == pytest.approx(expected, abs=1e-6)
        assert 0.0 < float(row[1]) < 1.0
    assert "section-gyro-scale-asymmetry" in printed
    assert "陀螺标度因数不对称度" in printed
    assert 'refType="basic_measuredValue mimucal_gyro_scale_asymmetry_x"' in printed


def test_an_error_source_is_a_line_of_the_budget(clone):
    clone.walk("An error source of the equipment")


@pytest.mark.real_time
def test_a_table_and_a_thermometer_of_a_bench_answer_and_move(clone):
    with bench() as clone.ports:
        clone.walk("A device")


def test_a_page_is_served_with_its_json_and_described(clone):
    clone.walk("A page")


def test_a_reader_imports_a_file(clone):
    values, _ = readings()
    units = dict.fromkeys(GYRO, "rad/s") | dict.fromkeys(ACCEL, "m/s2")
    names = ("time [s]", *(f"{name} [{unit}]" for name, unit in units.items()))
    rows = np.column_stack([np.arange(len(values)) / RATE_HZ, values])
    lines = [json.dumps(dict(zip(names, row, strict=True))) for row in rows.tolist()]
    (clone.folder / "log.jsonl").write_text("\n".join(lines), encoding="utf-8")
    clone.walk("A reader of a file format")


def test_a_language_is_spoken_by_a_report(clone):
    clone.walk("A language")
    clone.run(REPORT)
    report = (clone.folder / "report" / "report.html").read_text(encoding="utf-8")
    assert 'lang="de"' in report
    assert "in Hebelarm" in report
