"""An entry of the result's information."""

from collections.abc import Iterable, Sequence

import numpy as np

from schemas.calibration import Elements, Information
from schemas.recording import AXES
from tasks.words import Message, message, say
from tasks.words.rounding import USUAL_K

Numbers = Sequence[float | None] | np.ndarray


def entry(
    name: str,
    unit: str,
    value: Numbers,
    u: Numbers,
    *sentences: Message,
    elements: Iterable[str] = AXES,
    factor: float = 1.0,
    k: float = USUAL_K,
    about: str | None = None,
) -> Information:
    """Values with standard uncertainties, one of each element, NaN where there is none; U = k·u.

    name: of the title's message; sentences: what it is and how it was found; factor: from the
    values' unit to the printed one; about: the item that it stands beside.
    """
    title = message(f"information-{name.replace('_', '-')}")
    values = factor * np.array(value, float)
    us = np.where(np.isfinite(values), factor * np.array(u, float), np.nan)

    def known(numbers: np.ndarray) -> Elements:
        finite = (float(n) if np.isfinite(n) else None for n in numbers)
        return dict(zip(elements, finite, strict=True))

    return Information(
        title=say(title, "en"),
        title_zh=say(title, "zh"),
        unit=unit,
        value=known(values),
        u=known(us),
        U=known(k * us),
        k=k,
        about=about,
        en=" ".join(say(sentence, "en") for sentence in sentences),
        zh="".join(say(sentence, "zh") for sentence in sentences),
    )


def of_axes(id_: str, axes: Sequence[str], **arguments: str) -> list[Message]:
    """A sentence about some axes; none where there are none."""
    return [message(id_, axes=", ".join(axes), **arguments)] if axes else []
