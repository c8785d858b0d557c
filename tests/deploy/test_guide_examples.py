"""Examples of the guides are files that the program reads."""

import re
import tomllib
from pathlib import Path

import pytest

from schemas.certificate import Laboratory
from schemas.equipment import EquipmentFile
from tasks.conformity import check_capabilities

GUIDE = Path("deploy/guide")
PARTY = {"name": "L", "name_zh": "实", "address": "a", "address_zh": "址"}


def examples(page: str, mark: str) -> list[str]:
    text = (GUIDE / page).read_text(encoding="utf-8")
    return [each for each in re.findall(r"```toml\n(.*?)```", text, re.DOTALL) if mark in each]


@pytest.mark.parametrize("number", [0, 1])
def test_the_standards_of_the_guide_go_into_the_register(number: int) -> None:
    example = examples("reminders.md", "[[equipment]]")[number]
    (standard,) = EquipmentFile.model_validate(tomllib.loads(example)).equipment
    assert standard.limits or standard.functions


def test_the_capabilities_of_the_guide_are_read() -> None:
    (example,) = examples("certificates.md", "[[capabilities]]")
    laboratory = Laboratory.model_validate({"party": PARTY} | tomllib.loads(example))
    assert len(laboratory.capabilities) == 2
    check_capabilities(laboratory.capabilities)
