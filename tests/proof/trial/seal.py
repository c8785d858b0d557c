"""Recordings handed out, their truth sealed elsewhere, and the seals: a SHA-256 for each file."""

import hashlib
import json
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from tests.proof.plant.case import Case
from tests.proof.plant.files import seal, write
from tests.proof.plant.simulate import simulate
from tests.proof.plant.visibility import at_visibility, visibility
from tests.proof.trial.certificate import certificate_of
from tests.proof.trial.draw import Drawn, conditions
from tests.proof.trial.floor import floor_of

RECORDINGS, SEALED, SEALS = "recordings", "sealed", "seals.txt"


def record_and_seal(drawn: Drawn, folder: Path) -> None:
    """Sizes and plays one case: its recording, and apart from it its truth.

    Writes recordings/<number>/ and sealed/<number>/ with truth.json, truth.parquet and
    trial.json: kind, z asked, z and concealment of each effect as they came out, the floor
    that noise alone sets to the misfit, and the certificate of the same run without effects.
    """
    case = sized(drawn)
    simulated = simulate(case)
    observation = {call.name: visibility(simulated, call.name) for call in case.effects}
    write(simulated.recording, folder / RECORDINGS / drawn.label)
    sealed = folder / SEALED / drawn.label
    seal(simulated.recording, simulated.sealed, simulated.truth, sealed)
    clean = simulate(case.only())
    declared = {
        "kind": drawn.kind,
        "asked_z": drawn.z,
        "z": {name: each.z for name, each in observation.items()},
        "concealment": {name: each.concealment for name, each in observation.items()},
        "floor": floor_of(clean),
        "certificate": certificate_of(clean.recording),
    }
    (sealed / "trial.json").write_text(json.dumps(declared, indent=1), encoding="utf-8")


def sized(drawn: Drawn) -> Case:
    """The case with each effect at the z asked of it.

    An effect that the drawn procedure cannot have or show is played on three axes with every
    rate; what the standard absorbs there, too, keeps its typical size.
    """
    if drawn.z is None:
        return drawn.case
    try:
        return _at(drawn.case, drawn.z)
    except ValueError:
        case = _on_three_axes(drawn)
    try:
        return _at(case, drawn.z)
    except ValueError:
        return case


def _at(case: Case, z: float) -> Case:
    for call in case.effects:
        case = at_visibility(case, call.name, z)
    return case


def _on_three_axes(drawn: Drawn) -> Case:
    rng = np.random.default_rng([drawn.case.seed, 7])
    effects = tuple(call.name for call in drawn.case.effects)
    case = conditions(rng, (drawn.kind, effects, drawn.z), "three_axis")
    return case.model_copy(update={"temperature_recorded": True})


def set_seals(folder: Path) -> str:
    """Writes seals.txt, as `sha256sum -c` reads it; returns the SHA-256 of seals.txt itself."""
    files = sorted(path for path in (folder / SEALED).rglob("*") if path.is_file())
    lines = [f"{digest_of(path)}  {path.relative_to(folder).as_posix()}\n" for path in files]
    (folder / SEALS).write_text("".join(lines), encoding="utf-8")
    return digest_of(folder / SEALS)


def check_seals(folder: Path) -> None:
    """Raises Unusable where a sealed file is missing, was changed or came later."""
    sealed: dict[str, str] = {}
    for line in (folder / SEALS).read_text(encoding="utf-8").splitlines():
        digest, _, name = line.partition("  ")
        sealed[name] = digest
    there = {
        path.relative_to(folder).as_posix(): path
        for path in (folder / SEALED).rglob("*")
        if path.is_file()
    }
    for name in sorted(sealed.keys() | there.keys()):
        if name not in there or digest_of(there[name]) != sealed.get(name):
            raise Unusable(
                f"{folder / name} is not what was sealed in {folder / SEALS}; this trial proves "
                "nothing any more: run `make prove` again into a new folder"
            )


def digest_of(path: Path) -> str:
    """SHA-256 (hex) of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
