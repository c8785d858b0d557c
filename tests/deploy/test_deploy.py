"""What is shipped beside the program: unit files, the container's recipe, settings, licences."""

import configparser
import json
import re
import shlex
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
import typer.main
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from deploy.licences import as_markdown, packages
from deploy.settings_page import PAGE, text
from flows.cli import app
from flows.operating_commands import _write_unit
from schemas.laboratory import variables
from storage.home import Home

# Unit files and the container's recipe: what can be held without starting them.

UNITS = sorted(Path("deploy/systemd").glob("mimucal-*"))
RECIPE = Path("deploy/container/Containerfile")


def read(unit: Path) -> configparser.RawConfigParser:
    parser = configparser.RawConfigParser(
        strict=False, comment_prefixes="#"
    )  # Environment= repeats
    parser.optionxform = str  # type: ignore[method-assign]
    parser.read_string(unit.read_text(encoding="utf-8"))
    return parser


def mimucal_commands() -> set[str]:
    return set(typer.main.get_command(app).commands)


@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.name)
def test_a_unit_runs_a_command_that_is_there_as_a_user_of_its_own(unit):
    parser = read(unit)
    assert parser["Unit"]["Description"].startswith("mimucal: ")
    if unit.suffix != ".service":
        return
    command = shlex.split(parser["Service"]["ExecStart"])
    commands = {"mimucal": mimucal_commands(), "prefect": {"server", "worker"}}
    program = command[0].removeprefix("/opt/mimucal/.venv/bin/")
    assert command[1] in commands[program]
    assert parser["Service"]["User"] == "mimucal"


def test_each_unit_that_another_names_is_there():
    names = {unit.name for unit in UNITS}
    named = {read(unit)["Unit"].get("OnFailure") for unit in UNITS} - {None}
    assert named <= names
    assert {u.with_suffix(".service").name for u in UNITS if u.suffix == ".timer"} <= names


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is missing")
def test_systemd_reads_the_units_without_a_word(tmp_path):
    for unit in UNITS:  # /opt/mimucal is not there
        own = re.sub(r"/opt/mimucal/\.venv/bin/\w+", "/bin/true", unit.read_text())
        (tmp_path / unit.name).write_text(own.replace("User=mimucal\n", ""))
    command = ["systemd-analyze", "verify", "--man=no", *map(str, sorted(tmp_path.iterdir()))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    warnings = [line for line in done.stderr.splitlines() if "mimucal" in line]
    assert warnings == []


@pytest.fixture
def station_units(tmp_path, monkeypatch) -> tuple[Path, Path]:
    """The units of stations with one id, of two lines on one computer."""
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:4201/api")
    homes = (Home(tmp_path / "mimucal"), Home(tmp_path / "mimucal-b"))
    one, other = (_write_unit("S-1", home) for home in homes)
    return one, other


def test_two_lines_with_one_station_id_have_units_and_variables_of_their_own(station_units):
    one, other = station_units
    assert one.name == "mimucal-station-S-1.service"
    assert other.name == "mimucal-b-station-S-1.service"
    assert read(one)["Service"]["EnvironmentFile"] == "-/etc/mimucal/environment"
    assert read(other)["Service"]["EnvironmentFile"] == "-/etc/mimucal-b/environment"
    command = shlex.split(read(other)["Service"]["ExecStart"])
    assert command[:3] == [  # no variable of a file wins over these
        "/usr/bin/env", f"MIMUCAL_HOME={other.parents[1]}",
        "PREFECT_API_URL=http://127.0.0.1:4201/api",
    ]  # fmt: skip
    assert command[-3:] == ["station", "work", "S-1"]


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is missing")
def test_systemd_reads_the_unit_of_a_station_without_a_word(station_units):
    command = ["systemd-analyze", "verify", "--man=no", *map(str, station_units)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert [line for line in done.stderr.splitlines() if "mimucal" in line] == []


def lines() -> list[list[str]]:
    """The recipe's instructions, each as its words; continued lines are one."""
    whole = re.sub(r"\\\n\s*", " ", RECIPE.read_text(encoding="utf-8"))
    return [line.split() for line in whole.splitlines() if line and not line.startswith("#")]


def test_the_recipe_ends_as_a_user_that_is_not_root_in_a_stage_without_build_tools():
    found = lines()
    stages = [n for n, line in enumerate(found) if line[0] == "FROM"]
    assert len(stages) == 2
    last = found[stages[-1] :]
    users = [line[1] for line in last if line[0] == "USER"]
    assert users
    assert users[-1] != "root"
    assert not any("pip" in line for line in last)
    assert all(":" in found[n][1] for n in stages)  # a version of the base image is named


def test_the_recipe_copies_what_is_there_and_the_context_has_it():
    kept = Path(".containerignore").read_text().split()
    for line in lines():
        if line[0] == "COPY" and not line[1].startswith("--from"):
            for name in line[1:-1]:
                assert Path(name).exists()
                assert f"!{name}" in kept


def test_the_recipe_names_no_host_and_no_secret():
    text = RECIPE.read_text(encoding="utf-8")
    hosts = set(re.findall(r"https?://([\w.-]+)", text))
    assert hosts <= {"127.0.0.1"}
    assert not re.search(r"password|secret|token|passphrase", text, re.IGNORECASE)
    installs = [line for line in lines() if "-r" in line]
    assert all("--require-hashes" in line for line in installs)
    (command,) = (line for line in lines() if line[0] == "CMD")
    assert command[1].strip('[",') in mimucal_commands()


# deploy/guide/settings.md is what the models say.


def test_the_page_of_settings_is_that_of_the_models():
    assert PAGE.read_text(encoding="utf-8") == text()  # else: python deploy/settings_page.py


def test_every_variable_is_on_the_page():
    assert all(f"| `{name}` |" in text() for name in variables().values())


# The licence list and the bill of materials are complete, and no product package is a test's.

DEPLOY = Path("deploy")


def pinned(name: str) -> dict[str, str]:
    return {each.name: each.version for each in packages(Path(name).read_text())}


def test_every_pinned_package_is_in_both_and_no_other():
    product = pinned("requirements.txt")
    listed = json.loads((DEPLOY / "bom.json").read_text())["components"]
    assert {each["name"]: each["version"] for each in listed} == product
    rows = (DEPLOY / "licences.md").read_text().splitlines()
    table = [row.split(" | ") for row in rows[rows.index("| package | version | licence | only "
                                                         "where |") + 2 :] if row]  # fmt: skip
    assert {row[0].removeprefix("| "): row[1] for row in table} == product
    assert not any("not stated" in row for row in rows)


def test_the_bill_of_materials_is_valid():
    text = (DEPLOY / "bom.json").read_text()
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None


def test_the_program_installs_nothing_that_only_tests_need_and_pins_what_they_pin():
    product, everything = pinned("requirements.txt"), pinned("requirements-dev.txt")
    assert product.items() <= everything.items()
    project = tomllib.loads(Path("pyproject.toml").read_text())
    needed = {canonicalize_name(Requirement(each).name)
              for each in project["project"]["dependencies"]}  # fmt: skip
    tests = {
        canonicalize_name(Requirement(each).name)
        for group in project["dependency-groups"].values()
        for each in group
    }
    assert needed <= product.keys()
    only_tests = tests & product.keys() - needed
    assert only_tests <= {"setuptools"}
    for name in ("requirements.txt", "requirements-dev.txt"):
        assert "://" not in Path(name).read_text()


def test_a_package_without_a_licence_would_be_seen():
    (numpy,) = packages("numpy==1 \\\n    --hash=sha256:00\n")
    assert "| numpy | 1 |" in as_markdown([numpy])
    assert packages("other==2 ; sys_platform == 'win32' \\\n")[0].when == "sys_platform == 'win32'"
