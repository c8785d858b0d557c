"""Latitude and heading of a station that its manifests omit, from Earth's rotation.

In the runs of a station the ground turns about one direction of its base, whatever unit is on it.
The part along the vertical cannot be told from gyros that follow gravity, which the standard's
model lets them do; the level part Ω·cos φ can, and points north.
"""

from collections.abc import Iterator

import numpy as np

from schemas.review import EstimatedSite
from tasks.model.regression import inverse
from tasks.motion.table import EARTH_RATE
from tasks.review.ground import NAME
from tasks.review.hypotheses import Effect
from tasks.review.pool import Pool
from tasks.words import message, statement
from tasks.words.quantities import quantity

K = 2.0
CLEAR = 3.0  # standard uncertainties of the level rate from which on it has a direction


def sites_of(pool: Pool) -> tuple[EstimatedSite, ...]:
    """What the runs of each station say of its site, where their manifests do not."""
    terms = {t.model_dump_json(): t for g in pool.groups for t in g.layout.terms if t.name == NAME}
    return tuple(site for term in terms.values() for site in _sites(pool, Effect(term, (0, 1))))


def _sites(pool: Pool, level: Effect) -> Iterator[EstimatedSite]:
    score, information = pool.evidence(level)
    seen = information.any(axis=(1, 2))
    for number, station in enumerate(pool.names["station"]):
        rows = seen & (pool.carrier["station"] == number)
        if rows.any():
            covariance = inverse(information[rows].sum(axis=0))
            yield estimated(
                station, int(rows.sum()), covariance @ score[rows].sum(axis=0), covariance
            )


def estimated(station: str, runs: int, rate: np.ndarray, covariance: np.ndarray) -> EstimatedSite:
    """rate: (2,) rad/s of the ground along the table's x and y axes, all angles zero."""
    size = float(np.hypot(*rate))
    along, across = rate / size, np.array([rate[1], -rate[0]]) / size
    u_size = float(np.sqrt(along @ covariance @ along))
    u_turn = float(np.degrees(np.sqrt(across @ covariance @ across) / size))
    cosine = size / EARTH_RATE
    if size < CLEAR * u_size or cosine > 1.0 + CLEAR * u_size / EARTH_RATE:
        nothing = message("review-site-unknown", station=station, runs=runs)
        return EstimatedSite(
            station=station, runs=runs, latitude_deg=None, latitude_expanded=None,
            heading_deg=None, heading_expanded=None, statement=statement(nothing),
        )  # fmt: skip
    latitude = float(np.degrees(np.arccos(min(cosine, 1.0))))
    sine = max(np.sin(np.radians(latitude)), np.sqrt(K * u_size / EARTH_RATE))  # near the equator
    wide = K * float(np.degrees(u_size / EARTH_RATE / sine))
    heading = float(np.degrees(np.arctan2(-rate[0], rate[1])))
    words = message(
        "review-site", station=station, runs=runs, latitude=quantity(latitude, wide, "deg"),
        heading=quantity(heading, K * u_turn, "deg"),
    )  # fmt: skip
    return EstimatedSite(
        station=station, runs=runs, latitude_deg=latitude, latitude_expanded=wide,
        heading_deg=heading, heading_expanded=K * u_turn, statement=statement(words),
    )  # fmt: skip
