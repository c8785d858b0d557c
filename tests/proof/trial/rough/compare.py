"""Parameters that an engine states of a rough recording, beside the true ones."""

from collections.abc import Iterator, Sequence
from typing import Any

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
    true = {name: values for name, values in declared["nuisances"].items() if name not in plain}
    truth = Truth(true | plain, declared["parameters"], declared["case"]["case"])
    for finding in named:
        if finding["effect"] in truth.effects:
            pairs, _ = compared(truth, finding["effect"], finding["parameters"])
            yield from pairs
