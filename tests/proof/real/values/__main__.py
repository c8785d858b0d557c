"""`python -m tests.proof.real.values FOLDER... --out DIR`: the page of values, real.md."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from schemas.recording import Recording
from storage.formats.folder import read_folder
from tasks.version import code_version
from tests.proof.real.hand.measured import Measured
from tests.proof.real.values.by_hand import ByHand, Key, by_hand, by_others
from tests.proof.real.values.page import Explained, markdown
from tests.proof.real.values.run import explained
from tests.surroundings import leave_production


def main(
    folders: Annotated[list[Path], typer.Argument(help="Folders that hold recordings.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="For the page and the answers.")],
    kept_only: Annotated[
        bool, typer.Option("--kept-only", help="Nothing but recordings with an answer in DIR.")
    ] = False,
) -> None:
    """Explain every recording that has no answer in DIR yet, and write real.md after each."""
    out.mkdir(parents=True, exist_ok=True)
    found = sorted(path.parent for folder in folders for path in folder.glob("*/manifest.json"))
    every = []
    for path in found:
        kept = out / f"{path.name}.json"
        if not kept.exists():
            if kept_only:
                continue
            answer = explained(read_folder(path))
            kept.write_text(json.dumps(answer, indent=1, ensure_ascii=False) + "\n")
        answer = json.loads(kept.read_text(encoding="utf-8"))
        named = any(one["effect"] != "unnamed" for one in answer["findings"])
        hand = _by_hand(path.name, read_folder(path), out) if named else {}
        every.append(Explained(path.name, answer, hand, by_others(path.name)))
        (out / "real.md").write_text(markdown(every, code_version()), encoding="utf-8")


def _by_hand(name: str, recording: Recording, out: Path) -> Mapping[Key, ByHand]:
    """The values by hand, which take longer than an explanation; kept beside the answer."""
    kept = out / f"{name}.hand.jsonl"
    if not kept.exists():
        rows = (
            json.dumps([*key, one.value.value, one.value.u, one.value.unit, one.how])
            for key, one in by_hand(name, recording).items()
        )
        kept.write_text("".join(f"{row}\n" for row in rows), encoding="utf-8")
    found = {}
    for row in kept.read_text(encoding="utf-8").splitlines():
        effect, parameter, value, u, unit, how = json.loads(row)
        found[effect, parameter] = ByHand(Measured(value, u, unit), how)
    return found


if __name__ == "__main__":
    leave_production()
    typer.run(main)
