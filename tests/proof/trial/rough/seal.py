"""Rough recordings handed out, their truth sealed elsewhere."""

import json
from pathlib import Path

from tests.proof.plant.files import seal, write
from tests.proof.plant.rough.effects import KNOWN
from tests.proof.plant.rough.play import play
from tests.proof.plant.rough.standing import BY_SIZE, at_standing, standing, without
from tests.proof.trial.rough.draw import OUTSIDE_STANDINGS, RoughDrawn
from tests.proof.trial.seal import RECORDINGS, SEALED


def record_and_seal_rough(drawn: RoughDrawn, folder: Path) -> None:
    """Sizes and plays one case: its recording, and apart from it its truth.

    Writes recordings/<number>/ and sealed/<number>/ with truth.json, truth.parquet and
    trial.json: kind, z asked, and how far each effect stands above everything else.
    """
    rough = drawn.rough
    calls = [call.name for call in rough.case.effects]
    for place, called in enumerate(calls):
        others = rough.without(*calls[place + 1 :])
        outside = KNOWN[called].name.startswith("x_")
        wanted = OUTSIDE_STANDINGS[place % 2] if outside else drawn.z
        sized, _ = at_standing(others, called, wanted)
        rough = rough.with_strength(called, sized.case.effects[place].strength)
    played = play(rough)
    declared = {
        "kind": drawn.kind,
        "asked_z": drawn.z,
        "z": {
            called: standing(played, play(without(rough, called)), called in BY_SIZE)
            for called in calls
        },
    }
    write(played.recording, folder / RECORDINGS / drawn.label)
    sealed = folder / SEALED / drawn.label
    seal(played.recording, played.sealed, played.truth, sealed)
    (sealed / "trial.json").write_text(json.dumps(declared, indent=1), encoding="utf-8")
