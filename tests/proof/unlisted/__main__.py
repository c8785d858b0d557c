"""`python -m tests.proof.unlisted --out DIR`: laws that nobody listed, and clean runs of theirs."""

import json
from pathlib import Path
from typing import Annotated

import typer

from flows.progress import counting
from tasks.explain.explain import explain
from tasks.version import code_version
from tests.proof.plant.unlisted import LAWS, case_of, recordings
from tests.proof.unlisted.judge import judged
from tests.proof.unlisted.page import Answered, markdown
from tests.surroundings import leave_production

VISIBILITIES = (0.0, 10.0, 30.0, 100.0)  # 0: the same run without the law


def main(
    out: Annotated[Path, typer.Option(metavar="DIR", help="For the page and the answers.")],
    seed: Annotated[int, typer.Option(min=0, help="Of the first law's run.")] = 4701,
) -> None:
    """Explain a run of each law at each visibility, and write unlisted.md and unlisted.json."""
    out.mkdir(parents=True, exist_ok=True)
    every: list[Answered] = []
    with counting("explain") as report:
        for number, law in enumerate(LAWS.values()):
            runs = recordings(law, case_of(law, seed + number), VISIBILITIES)
            for z, recording in zip(VISIBILITIES, runs, strict=True):
                report(len(every), len(LAWS) * len(VISIBILITIES))
                found = [
                    (one.effect, (*one.group, *one.indistinguishable))
                    for one in explain(recording).findings
                ]
                worth = judged(law.behaviour if z else None, found)
                every.append(Answered(law.name, law.behaviour, z, tuple(found), worth))
                version = code_version()
                (out / "unlisted.md").write_text(markdown(every, version), encoding="utf-8")
                rows = [{"law": a.law, "z": a.z, "findings": a.findings} for a in every]
                data = json.dumps({"code_version": version, "runs": rows}, indent=1)
                (out / "unlisted.json").write_text(data + "\n", encoding="utf-8")


if __name__ == "__main__":
    leave_production()
    typer.run(main)
