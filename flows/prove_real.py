"""`mimucal prove --real`: real recordings with a known secret."""

import json
from pathlib import Path

from flows.printing import print_rows, stdout
from flows.progress import counting
from flows.prove import make_new
from tasks.prove.real.hold import hold
from tasks.prove.real.page import data, markdown, page, summary
from tasks.version import code_version

DEFAULT_OUT = "proof-real"


def run_prove_real(real: Path, seed: int, out: Path | None, as_json: bool) -> None:
    """Hand analysis, known transformations hidden, explained blind and scored.

    Writes real.json, real.md and real.html. Raises Unusable for a folder that is in use or
    cannot be written, and where one of the recordings is missing or broken.
    """
    folder = out or Path(DEFAULT_OUT)
    make_new(folder)
    with counting("explain blind") as report:
        results = hold(real, folder, seed, code_version(), report)
    said = json.dumps(data(results), indent=1, ensure_ascii=False) + "\n"
    contents = {"real.json": said, "real.md": markdown(results), "real.html": page(results)}
    for name, text in contents.items():
        (folder / name).write_text(text, encoding="utf-8")
    if as_json:
        print(said, end="")
        return
    print_rows("Real recordings with a known secret", ("", ""), summary(results))
    console = stdout(markup=False)
    for name in contents:
        console.print(str(folder / name))
