"""Writes deploy/guide/settings.md from the models: `python deploy/settings_page.py`."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from schemas.access import PagesFile
from schemas.certificate import Laboratory, Order
from schemas.laboratory import Environment
from schemas.orders import QualityFile
from schemas.station import StationFile
from schemas.store import RecallFile
from schemas.tolerance import Tolerance

PAGE = Path(__file__).parent / "guide" / "settings.md"
FILES: tuple[tuple[str, type[BaseModel]], ...] = (
    ("`laboratory.toml` in the home", Laboratory),
    ("`recall.toml` in the home", RecallFile),
    ("`pages.toml` in the home", PagesFile),
    ("`quality.toml` in the home", QualityFile),
    ("Limits (`tolerances/*.toml` in the home)", Tolerance),
    ("A client's order (`client-orders/*.toml` in the home)", Order),
    ("A station file (`stations/*.toml` in the home)", StationFile),
)
HEAD = """# Settings

Every setting of the program, made from its models by `python deploy/settings_page.py`; a test holds
this page to them. `mimucal settings` shows the variables as they are now, secrets as `***`, and
names one that is set by mistake. What is set in a file of the home is checked by `mimucal doctor`,
and whenever it is used.

## Environment variables

An empty variable counts as not set. Besides these, Prefect, dask and AWS have their own.

| variable | default | what it is |
|---|---|---|
"""


def text() -> str:
    """The page."""
    return HEAD + "".join(_variables()) + "".join(_of_files())


def _variables() -> Iterator[str]:
    for field in Environment.model_fields.values():
        default = "" if field.default is None else f"`{field.default}`"
        secret = "" if field.repr else " Secret."
        yield f"| `{field.alias}` | {default} | {field.description}{secret} |\n"


def _of_files() -> Iterator[str]:
    shown: set[str] = set()
    for title, model in FILES:
        schema = model.model_json_schema()
        yield f"\n## {title}\n"
        yield from _model(None, schema)
        for name, part in schema.get("$defs", {}).items():
            if "properties" in part and name not in shown:
                shown.add(name)
                yield from _model(name, part)


def _model(name: str | None, schema: dict[str, Any]) -> Iterator[str]:
    if name is not None:
        yield f"\n### {name}\n"
    if about := schema.get("description"):
        yield f"\n{_plain(about)}\n"
    yield "\n| field | type | default | what it is |\n|---|---|---|---|\n"
    for field, about in schema["properties"].items():
        is_needed = field in schema.get("required", ())
        default = "needed" if is_needed else f"`{json.dumps(about.get('default'))}`"
        what = _plain(about.get("description", ""))
        yield f"| `{field}` | {_cell(_type(about))} | {_cell(default)} | {_cell(what)} |\n"


def _type(about: dict[str, Any]) -> str:
    """A JSON schema in a few words."""
    if "$ref" in about:
        return str(about["$ref"].rsplit("/", 1)[1])
    if values := about.get("enum") or ([about["const"]] if "const" in about else []):
        return " or ".join(f"`{json.dumps(each)}`" for each in values)
    if several := about.get("anyOf") or about.get("oneOf"):
        return " or ".join(map(_type, several))
    kind = str(about.get("type", "anything"))
    if kind == "array":
        inner = about.get("items") or {}
        return f"list of {_type(inner)}" if inner else "list"
    if kind == "object" and isinstance(about.get("additionalProperties"), dict):
        return f"table of {_type(about['additionalProperties'])}"
    return str(about.get("format", kind))


def _plain(words: str) -> str:
    return " ".join(words.split())


def _cell(words: str) -> str:
    return words.replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_text(text(), encoding="utf-8")
