"""`python -m tests.proof.real.stated FOLDER... --out DIR`: the page of claims."""

import json
from pathlib import Path
from typing import Annotated

import typer

from flows.progress import counting
from storage.formats.folder import read_folder
from tasks.version import code_version
from tests.proof.real.present import RECORDINGS, doubtful
from tests.proof.real.stated.judge import judged
from tests.proof.real.stated.known import KNOWN
from tests.proof.real.stated.page import Answered, data, markdown
from tests.proof.real.stated.run import Cost, explained
from tests.surroundings import leave_production


def main(
    folders: Annotated[list[Path], typer.Argument(help="Folders that hold recordings.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="For the page and the answers.")],
    before: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Costs of an older engine, a line of JSON each: recording, seconds, memory.",
        ),
    ] = None,
) -> None:
    """Explain every recording once, judge every claim, and write stated.md and stated.json."""
    out.mkdir(parents=True, exist_ok=True)
    found = sorted(path.parent for folder in folders for path in folder.glob("*/manifest.json"))
    by_name = {path.name: path for path in found}
    tried = doubtful({name: read_folder(by_name[name]) for name in RECORDINGS})
    older = {} if before is None else dict(map(_cost, before.read_text().splitlines()))
    every = []
    with counting("explain") as report:
        for number, (name, path) in enumerate(by_name.items()):
            report(number, len(by_name))
            answer, cost = explained(path, out)
            own = [claim for claim in tried if claim.recording == name]
            claims = tuple(judged(name, answer or {}, KNOWN, own))
            every.append(Answered(name, answer, claims, cost, older.get(name)))
            version = code_version()
            (out / "stated.md").write_text(markdown(every, version), encoding="utf-8")
            response = json.dumps(data(every, version), indent=1, ensure_ascii=False)
            (out / "stated.json").write_text(response + "\n", encoding="utf-8")


def _cost(line: str) -> tuple[str, Cost]:
    read = json.loads(line)
    return read["recording"], Cost(read["seconds"], read["memory"])


if __name__ == "__main__":
    leave_production()
    typer.run(main)
