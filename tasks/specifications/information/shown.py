"""How something that is shown beside the clauses becomes an entry of the result."""

import numpy as np

from schemas.calibration import Information
from tasks.specifications.parts import K_FACTOR, elements

Said = tuple[str, str]  # English, Chinese


def shown(
    title: Said,
    unit: str,
    value: np.ndarray,
    u: np.ndarray,
    *said: Said,
    about: str | None = None,
    which: tuple[tuple[int, int], ...] | None = None,
) -> Information:
    """Values (3,) or (3, 3) with standard uncertainties, in the unit told; U = 2·u.

    said: sentences; about: the item that it stands beside.
    """
    u = np.where(np.isfinite(value), u, np.nan)
    return Information(
        title=title[0],
        title_zh=title[1],
        unit=unit,
        value=elements(value, which),
        u=elements(u, which),
        U=elements(K_FACTOR * u, which),
        about=about,
        en=" ".join(en for en, _ in said),
        zh="".join(zh for _, zh in said),
    )
