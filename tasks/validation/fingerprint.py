"""A hash of the source that a method's numbers come from, kept in its validation record."""

import ast
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
# What is said beside the results, and stands in no result of an item.
BESIDE = (
    "tasks.calibrate.information",
    "tasks.specifications.readings",
    "tasks.specifications.register",  # which specifications there are
    "tasks.version",
    "tasks.words",
)
IMPORTS = (ast.Import, ast.ImportFrom)
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def fingerprint(method: str) -> str:
    """SHA-256 (first 16 hex digits) of the code of every file in `tasks` that a method imports.

    Directly or through others, without `BESIDE`. A record with another fingerprint is of another
    version of the estimation.
    """
    digest = hashlib.sha256()
    for source in sources(method):
        digest.update(source.relative_to(ROOT).as_posix().encode())
        digest.update(_read(source).code.encode())
    return digest.hexdigest()[:16]


def names_of(method: str) -> tuple[str, ...]:
    """The files that the fingerprint is of, by their names within `tasks`."""
    return tuple(source.relative_to(ROOT).as_posix() for source in sources(method))


def text_digest(names: Sequence[str]) -> str:
    """SHA-256 (first 16 hex digits) of files of `tasks` as they are written, comments and all."""
    digest = hashlib.sha256()
    for name in names:
        file = ROOT / name
        digest.update(name.encode())
        digest.update(file.read_bytes() if file.is_file() else b"")
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class Source:
    """A source file in one form, and the names of what it imports from `tasks`.

    code: what it computes: no comments, docstrings, layout or sentences; what it imports stands
    first, wherever a module is loaded.
    """

    code: str
    imports: tuple[str, ...]


@cache
def _read(path: Path) -> Source:
    return read_source(path.read_text(encoding="utf-8"))


def read_source(text: str) -> Source:
    """Reads a source file's text, parsed and walked once: parsing is what takes the time."""
    tree, names, imported = ast.parse(text), [], set[str]()
    for node in ast.walk(tree):
        if isinstance(body := getattr(node, "body", None), list):
            imported |= {ast.dump(each) for each in body if isinstance(each, IMPORTS)}
            body[:] = [each for each in body if not isinstance(each, IMPORTS)]
        if isinstance(node, DOCUMENTED):
            if node.body and ast.get_docstring(node, clean=False) is not None:
                node.body = node.body[1:]
        elif isinstance(node, ast.Call):
            if getattr(node.func, "id", "") == "message":
                node.args, node.keywords = [], []
        elif isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    code = "\n".join((*sorted(imported), ast.dump(tree)))
    return Source(code, tuple(name for name in names if name.startswith("tasks.")))


def sources(method: str) -> list[Path]:
    """The files, sorted."""
    known: set[Path] = set()
    waiting = [f"tasks.specifications.{method}", "tasks.calibrate.calibrate"]
    while waiting:
        path = _file(waiting.pop())
        if path is not None and path not in known:
            known.add(path)
            waiting.extend(_read(path).imports)
    return sorted(known)


def _file(module: str) -> Path | None:
    """The file of a module in `tasks`; None for a name that is no module or lies beside."""
    if any(module == name or module.startswith(f"{name}.") for name in BESIDE):
        return None
    path = ROOT.joinpath(*module.split(".")[1:])
    for candidate in (path.with_suffix(".py"), path / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None
