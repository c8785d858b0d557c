"""How large the engine is: lines, numeric constants, names of effects outside their own files."""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import tasks.explain
import tasks.words

EXPLAIN = Path(tasks.explain.__file__).parent
WORDS = Path(tasks.words.__file__).parent / "en"
ENTRY = re.compile(r"^effect-([a-z0-9-]+) *=", re.MULTILINE)
OF_EVENTS = "events"  # an event has its name from the file that finds it


@dataclass(frozen=True)
class Counts:
    """lines: without blanks. constants: of modules, numbers or made of numbers. names: literal
    names of effects, but those of an event where it is found; files: that have them.
    """

    lines: int
    constants: int
    names: int
    files: int


def counts(folder: Path = EXPLAIN) -> Counts:
    """Of all modules of a package."""
    effects = _effects()
    lines = constants = names = files = 0
    for path in sorted(folder.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text)
        lines += sum(bool(line.strip()) for line in text.splitlines())
        constants += sum(_numbers(tree))
        own = sum(_literal(node) in effects for node in ast.walk(tree))
        if OF_EVENTS not in path.parts:
            names, files = names + own, files + bool(own)
    return Counts(lines, constants, names, files)


def _effects() -> set[str]:
    every = (path.read_text(encoding="utf-8") for path in WORDS.iterdir())
    return {name.replace("-", "_") for text in every for name in ENTRY.findall(text)} - {"unnamed"}


def _literal(node: ast.AST) -> object:
    return node.value if isinstance(node, ast.Constant) else None


def _numbers(tree: ast.Module) -> Iterator[int]:
    """How many numeric constants each assignment of a module makes."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and _is_numeric(node.value):
            for target in node.targets:
                yield len(target.elts) if isinstance(target, ast.Tuple) else 1


def _is_numeric(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value=bool()):
            return False
        case ast.Constant(value=int() | float()):
            return True
        case ast.UnaryOp(operand=operand):
            return _is_numeric(operand)
        case ast.BinOp(left=left, right=right):
            return _is_numeric(left) or _is_numeric(right)
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            return bool(elements) and all(map(_is_numeric, elements))
        case ast.Call(args=arguments):
            return any(map(_is_numeric, arguments))
    return False
