"""An effect that nobody knows, whole in this file: the gyro reads with the root of its rate too."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import Recording
from tasks.model.parameters import GYRO_FIRST, each_axis, own
from tasks.model.term import Column, Inputs, Term
from tasks.motion.whole import Motion


@dataclass(frozen=True)
class RootOfRate(Term):
    """Readings that follow √|ω|."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        return own(GYRO_FIRST, np.sqrt(np.abs(inputs.rate)))


TOY_EFFECT = RootOfRate(
    "toy_effect", "gyro", "sensor", "ω′ᵢ = cᵢ·√|ωᵢ|", "this test",
    each_axis("coefficient", "c", ("(rad/s)^0.5", 1.0, 0.01)),
)  # fmt: skip


def candidates(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    return (TOY_EFFECT,)
