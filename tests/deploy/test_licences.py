"""The licence list and the bill of materials are complete, and no product package is a test's."""

import json
import tomllib
from pathlib import Path

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from deploy.licences import as_markdown, packages

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
