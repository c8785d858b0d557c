"""An entry of the result's information."""

from collections.abc import Mapping, Sequence

import numpy as np

from schemas.calibration import Elements, Information
from schemas.recording import AXES
from tasks.words import Message, message, say
from tasks.words.rounding import USUAL_K


def entry(
    title: Message,
    unit: str,
    value: Mapping[str, float],
    u: Mapping[str, float],
    *sentences: Message,
    about: str | None = None,
) -> Information:
    """Values with standard uncertainties by element, NaN where there is none; U = 2·u.

    sentences: what it is and how it was found; about: the item that it stands beside.
    """
    expanded = {element: USUAL_K * each for element, each in u.items()}
    return Information(
        title=say(title, "en"),
        title_zh=say(title, "zh"),
        unit=unit,
        value=_finite(value, value),
        u=_finite(u, value),
        U=_finite(expanded, value),
        about=about,
        en=" ".join(say(sentence, "en") for sentence in sentences),
        zh="".join(say(sentence, "zh") for sentence in sentences),
    )


def by_axis(values: Sequence[float] | np.ndarray) -> dict[str, float]:
    """(3,) values by axis."""
    return dict(zip(AXES, map(float, values), strict=True))


def of_axes(id_: str, axes: Sequence[str], **arguments: str) -> list[Message]:
    """A sentence about some axes; none where there are none."""
    return [message(id_, axes=", ".join(axes), **arguments)] if axes else []


def _finite(numbers: Mapping[str, float], value: Mapping[str, float]) -> Elements:
    known = {e for e in value if np.isfinite(value[e])}
    return {e: n if e in known and np.isfinite(n) else None for e, n in numbers.items()}
