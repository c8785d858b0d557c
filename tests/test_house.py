"""The rules of the house that no linter knows."""

import ast
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from fluent.syntax import ast as fluent
from fluent.syntax import parse

PRODUCT = ("flows", "tasks", "schemas", "storage")
CATALOGUES = Path("tasks/words")
CHINESE = re.compile("[\u3000-\u303f\u4e00-\u9fff\uff00-\uffef]")


def sources(rooms: Sequence[str] = PRODUCT) -> list[Path]:
    return sorted(path for room in rooms for path in Path(room).rglob("*.py"))


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def nodes(rooms: Sequence[str] = PRODUCT) -> Iterator[tuple[Path, ast.AST]]:
    for path in sources(rooms):
        for node in ast.walk(parsed(path)):
            yield path, node


def test_chinese_stands_in_the_catalogues_and_templates_alone():
    found = [str(path) for path in sources() if CHINESE.search(path.read_text(encoding="utf-8"))]
    assert found == []


def test_nothing_is_told_apart_by_its_address():
    found = [
        f"{path}:{node.lineno}"
        for path, node in nodes()
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "id"
    ]
    assert found == []


def test_no_class_name_stands_in_three_places():
    names = Counter(node.name for _, node in nodes() if isinstance(node, ast.ClassDef))
    assert [name for name, count in names.items() if count > 2] == []


@cache
def messages() -> frozenset[str]:
    """Identifiers of the catalogues, “message” and “message.attribute”."""
    found = set()
    for source in sorted((CATALOGUES / "en").glob("*.ftl")):
        for entry in parse(source.read_text(encoding="utf-8")).body:
            if isinstance(entry, fluent.Message):
                if entry.value is not None:
                    found.add(entry.id.name)
                found |= {f"{entry.id.name}.{each.id.name}" for each in entry.attributes}
    return frozenset(found)


def templates() -> str:
    paths = (path for end in ("ftl", "html", "typ") for path in Path("tasks").rglob(f"*.{end}"))
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


def strings() -> Iterator[str]:
    return (
        node.value
        for _, node in nodes()
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


def test_every_message_of_the_catalogues_is_used():
    """Whole, put together behind a beginning (“item-”), or before an attribute (“.heading”)."""
    literals, pages = set(strings()), templates()
    written = literals | set(re.findall(r"[\w.-]+", pages))
    begun = tuple(text for text in written if re.fullmatch(r"[a-z0-9]+-([a-z0-9.-]*[-.])?", text))
    attributes = {text for text in written if re.fullmatch(r"\.[a-z-]+", text)}
    defined = Counter(re.findall(r"^[a-z0-9-]+(?= =)", pages, re.MULTILINE))
    unused = [
        name
        for name in sorted(messages())
        if not name.startswith(begun)
        and f".{name.partition('.')[2]}" not in attributes
        and not (name in written and (name not in defined or name in literals))
    ]
    assert unused == []


def test_every_message_that_the_code_names_stands_in_the_catalogues():
    asked = {
        (f"{path}:{node.lineno}", node.args[0].value)
        for path, node in nodes()
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "message"
        and node.args
        and isinstance(node.args[0], ast.Constant)
    }
    assert [where for where, name in sorted(asked) if name not in messages()] == []
