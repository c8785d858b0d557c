"""The part of `mimucal prove` that holds real recordings with a known secret."""

import json
from pathlib import Path

from flows.progress import counting
from tasks.prove.real.hold import Results, hold
from tasks.prove.real.page import data, markdown, page
from tasks.version import code_version


def prove_real(real: Path, folder: Path, seed: int) -> Results:
    """Hand analysis, known transformations hidden, explained blind and scored.

    Writes recordings, answers, real.json, real.md and real.html to the folder. Raises Unusable
    where one of the recordings is missing or broken.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with counting("real recordings") as report:
        results = hold(real, folder, seed, code_version(), report)
    said = json.dumps(data(results), indent=1, ensure_ascii=False) + "\n"
    contents = {"real.json": said, "real.md": markdown(results), "real.html": page(results)}
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    return results
