"""Whether a slow quantity was recorded over the whole run."""

import numpy as np

from schemas.recording import Segment, Stream
from tasks.segments.summarise import SegmentMean

SHARE = 0.05  # of the run: farther from a reading nothing is known
LEAST, MOST = 10.0, 300.0  # s, whatever the run's length: a logger's interval, a room's drift


def readings(stream: Stream | None, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) s and values (n,) of a column where it was recorded."""
    if stream is None or column not in stream.columns:
        return np.empty(0), np.empty(0)
    values = stream.columns[column]
    known = np.isfinite(values)
    return stream.t[known], values[known]


def not_covered(t: np.ndarray, segments: tuple[SegmentMean, ...]) -> list[str]:
    """The names of the segments with a time that is far from every reading at t (n,) s."""
    if not segments:
        return []
    begin, end = min(s.t_start for s in segments), max(s.t_end for s in segments)
    reach = float(np.clip(SHARE * (end - begin), LEAST, MOST))
    return [s.segment.name for s in segments if _farthest(t, s.segment, reach) > reach]


def _farthest(t: np.ndarray, segment: Segment, reach: float) -> float:
    """How far (s) from a reading the segment gets."""
    if not len(t):
        return float("inf")
    asked = np.append(np.arange(segment.t_start, segment.t_end, reach / 4), segment.t_end)
    after = np.clip(np.searchsorted(t, asked), 0, len(t) - 1)
    before = np.maximum(after - 1, 0)
    return float(np.minimum(np.abs(t[after] - asked), np.abs(t[before] - asked)).max())


def within(t: np.ndarray, values: np.ndarray, segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """The values at times t (n,) s that lie in a segment."""
    edges = np.array([(s.t_start, s.t_end) for s in segments]).reshape(-1, 2)
    rows = np.searchsorted(t, edges)
    return np.concatenate([values[start:stop] for start, stop in rows] or [np.empty(0)])
