"""`python -m tests.proof.real.values FOLDER... --out DIR`: the page of values, real.md."""

import json
from pathlib import Path
from typing import Annotated

import typer

from storage.formats.folder import read_folder
from tasks.version import code_version
from tests.proof.real.values.by_hand import by_hand
from tests.proof.real.values.page import Explained, markdown
from tests.proof.real.values.run import explained
from tests.surroundings import leave_production


def main(
    folders: Annotated[list[Path], typer.Argument(help="Folders that hold recordings.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="For the page and the answers.")],
) -> None:
    """Explain every recording that has no answer in DIR yet, and write real.md after each."""
    out.mkdir(parents=True, exist_ok=True)
    found = sorted(path.parent for folder in folders for path in folder.glob("*/manifest.json"))
    every = []
    for path in found:
        recording, kept = read_folder(path), out / f"{path.name}.json"
        if not kept.exists():
            kept.write_text(json.dumps(explained(recording), indent=1, ensure_ascii=False) + "\n")
        answer = json.loads(kept.read_text(encoding="utf-8"))
        named = any(one["effect"] != "unnamed" for one in answer["findings"])
        every.append(Explained(path.name, answer, by_hand(path.name, recording) if named else {}))
        (out / "real.md").write_text(markdown(every, code_version()), encoding="utf-8")


if __name__ == "__main__":
    leave_production()
    typer.run(main)
