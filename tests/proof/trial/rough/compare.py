"""Parameters that an engine states of a rough recording, beside the true ones."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from tests.proof.plant.rotations import from_vector, turned
from tests.proof.trial.compare import Compared, compared
from tests.proof.trial.parameters import Truth

SAME_PARAMETERS = ("bias_step_single", "bias_step_moving")  # forms that keep their meaning


def compared_rough(declared: dict[str, Any], named: Sequence[dict[str, Any]]) -> Iterator[Compared]:
    """Those that mean the same in both: of effects in the plain plant's form, or one with the same
    parameters, and of what the reference brings along. Other forms have parameters of their own.
    """
    plain = {
        each["name"]: each["parameters"]
        for each in declared["effects"]
        if each["called"] in (each["name"], *SAME_PARAMETERS)
    }
    true = {
        name: _along_reference(declared, values) if name == "lever_arm" else values
        for name, values in declared["nuisances"].items()
        if name not in plain
    }
    truth = Truth(true | plain, declared["parameters"], declared["case"]["case"])
    for finding in named:
        if finding["effect"] in truth.effects:
            pairs, _ = compared(truth, finding["effect"], finding["parameters"])
            yield from pairs


def _along_reference(declared: dict[str, Any], arm: Mapping[str, Any]) -> dict[str, Any]:
    """A lever arm along the axes of the body that the poses tell, as `explain` states it.

    The plant draws it along the unit's own axes, which are turned against those.
    """
    turn = from_vector(np.array(declared["case"]["tracking"]["turn"]))
    return {"r": turned(turn, np.array(arm["r"]))[:, 0].tolist()}
