"""Which source a method's numbers come from, as a hash that its validation record carries."""

import ast
import hashlib
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
        digest.update(code(source.read_text(encoding="utf-8")).encode())
    return digest.hexdigest()[:16]


def code(text: str) -> str:
    """What a source file computes, in one form: no comments, docstrings, layout or sentences."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(node, DOCUMENTED) and body and ast.get_docstring(node) is not None:
            node.body = body[1:]
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") == "message":
            node.args, node.keywords = [], []
    return ast.dump(tree)


def sources(method: str) -> list[Path]:
    """The files, sorted."""
    known: set[Path] = set()
    waiting = [f"tasks.specifications.{method}", "tasks.calibrate.calibrate"]
    while waiting:
        path = _file(waiting.pop())
        if path is not None and path not in known:
            known.add(path)
            waiting.extend(_imports(path))
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


@cache
def _imports(path: Path) -> tuple[str, ...]:
    """Names of modules in `tasks`, and of what is imported from them, that a file mentions."""
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(name for name in names if name.startswith("tasks."))
