"""The gain λ of Earth's rotation in a recording: 1 in full, 0 absent."""

from dataclasses import dataclass
from typing import Literal

from tasks.words import Message, message
from tasks.words.rounding import MINUS

REFUTED = 3.0  # standard uncertainties from a gain that the data then refute

State = Literal["present", "not_visible", "not_shown", "odd"]


@dataclass(frozen=True)
class EarthRotationGain:
    """The gain λ with its standard uncertainty, and what it rests on.

    level: from the horizontal part, which a g-sensitivity cannot imitate; else from readings up
    minus down, which contain a g-sensitivity too.
    """

    gain: float
    u: float
    level: bool

    @property
    def state(self) -> State:
        """Which of `present` (1) and `absent` (0) the data allow, at three u; odd: neither."""
        present = abs(self.gain - 1.0) <= REFUTED * self.u
        absent = abs(self.gain) <= REFUTED * self.u
        if present:
            return "not_visible" if absent else "present"
        if absent:
            return "not_shown"
        return "odd" if self.level else "not_visible"

    @property
    def refuted(self) -> bool:
        """Whether the data show that Earth's rotation is not in them."""
        return self.level and self.state == "not_shown"


def earth_rotation_message(earth: EarthRotationGain | None) -> Message:
    """What the data show of Earth's rotation, a clause without its full stop."""
    if earth is None:
        return message("earth-rotation-unknown")
    gain = f"λ = {earth.gain:.3f} ± {2.0 * earth.u:.3f}, k = 2".replace("-", MINUS)
    basis = "level" if earth.level else "vertical"
    return message(f"earth-rotation-{basis}-{earth.state.replace('_', '-')}", gain=gain)
