"""The segments of a recording by which a report says where something sits."""

import numpy as np

from schemas.recording import Recording, Segment
from tasks.motion.whole import attitude_stream, whole_motion
from tasks.segments.find import segments_of

TURNING = 0.1  # rad/s: what turns so much does not rest, whatever the noise of its poses


def shown_segments(recording: Recording) -> tuple[Segment, ...]:
    """The labelled segments, or those found; no rest where poses turn, as where a hand moves so
    evenly that the quietest tenth of its readings is no quieter than the rest.
    """
    segments = segments_of(recording)
    if recording.manifest.segments or attitude_stream(recording) is not recording.reference:
        return segments
    turns = np.linalg.norm(whole_motion(recording).rate, axis=1)
    return tuple(each for each in segments if not _turns(each, recording, turns))


def _turns(segment: Segment, recording: Recording, turns: np.ndarray) -> bool:
    own = turns[recording.imu.rows(segment.t_start, segment.t_end)]
    own = own[np.isfinite(own)]
    still = not len(own) or np.sqrt((own**2).mean()) < TURNING
    return segment.kind == "static" and not still
