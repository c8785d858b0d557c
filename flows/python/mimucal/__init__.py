"""Calibration of inertial units from Python: recordings in, results and tables out.

    import mimucal

    recording = mimucal.open("recording")  # a mimu-recording/1 folder, an MCAP file or a ROS 2 bag
    calibration = mimucal.calibrate(recording)
    table = mimucal.frame(calibration)     # a row for each element, with its U
    report = mimucal.explain(recording)    # which physics the model left out

Nothing here needs or changes a home; `mimucal` on the command line keeps, signs and publishes.
"""

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from schemas.base import Unusable
from schemas.calibration import Calibration, Method
from schemas.discrepancy import Discrepancy
from schemas.recording import Recording
from tasks.model.term import Term, nominal_values

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Unusable", "calibrate", "explain", "frame", "open", "readings", "simulate", "terms"]


def open(path: str | PathLike[str]) -> Recording:
    """A recording, checked as `mimucal import` does it; raises Unusable with one sentence.

    >>> recording = mimucal.open("recording")
    >>> recording.manifest.unit.serial
    'V00001'
    """
    from tasks.stages import import_recording

    return import_recording.read(Path(path))


def calibrate(recording: Recording, method: Method | None = None) -> Calibration:
    """Every item that the recording allows, with value, U and budget.

    method: jjf2003, jjf1536 or joint; None: that of the recording's standard. Limits are those of
    the specification. Raises Unusable for a recording that the method cannot use.

    >>> mimucal.calibrate(recording).items["gyro_bias"].value["x"]
    0.0843
    """
    from tasks.calibrate import calibrate as of_specification
    from tasks.specifications.register import specification_for
    from tasks.version import code_version

    specification = specification_for(recording.manifest.standard, method)
    return of_specification.calibrate(specification, recording, run="", code_version=code_version())


def frame(calibration: Calibration) -> "pd.DataFrame":
    """A row for each element of each item: value, u, U, k and unit; NaN where not determined.

    >>> mimucal.frame(calibration).query("item == 'gyro_bias'")
    """
    import pandas as pd

    rows = [
        {
            "item": key, "element": element, "value": value, "u": item.u.get(element),
            "U": item.U.get(element), "k": item.k, "unit": item.unit,
        }
        for key, item in calibration.items.items() for element, value in item.value.items()
    ]  # fmt: skip
    figures = dict.fromkeys(("value", "u", "U", "k"), float)
    return pd.DataFrame(rows).astype(figures)


def readings(recording: Recording) -> "pd.DataFrame":
    """What the unit read, by time in s: rad/s, m/s² and whatever else was recorded of it.

    >>> mimucal.readings(recording)["gyro_x"].rolling(100).mean().plot()
    """
    import pandas as pd

    return pd.DataFrame(dict(recording.imu.columns), index=pd.Index(recording.imu.t, name="t"))


def explain(recording: Recording, only: Sequence[str] | None = None) -> Discrepancy:
    """Where the standard's model and the recording differ, and which physics was left out.

    only: names of the catalogue that are fitted, without a search. Raises Unusable where the
    recording does not show how the unit moved.

    >>> [finding.effect for finding in mimucal.explain(recording).findings]
    ['time_offset']
    """
    from tasks.explain.correction.consequences import consequences
    from tasks.explain.explain import explain as explained
    from tasks.explain.locate.where import locate
    from tasks.explain.report import discrepancy_of

    explanation = explained(recording, only=only)
    effects = consequences(recording, explanation)
    wheres = locate(explanation) if explanation.findings else ()
    return discrepancy_of(explanation, wheres, effects)


def terms(recording: Recording) -> tuple[Term, ...]:
    """The catalogue's physics that this recording could show, each with equation and source.

    >>> {term.name for term in mimucal.terms(recording)} >= {"time_offset", "bandwidth"}
    True
    """
    from tasks.model.catalogue import catalogue
    from tasks.motion.whole import whole_motion

    return catalogue(recording, whole_motion(recording))


def simulate(
    recording: Recording, values: Mapping[str, Mapping[str, float]] | None = None
) -> "pd.DataFrame":
    """What a unit on this motion would read: an ideal one, or with terms of given values (SI).

    values: by the term's name and the parameter's; the first of the terms with a name is taken.
    Raises Unusable for a name that the recording's catalogue does not have.

    >>> late = mimucal.simulate(recording, {"time_offset": {"seconds": 0.004}})
    """
    import pandas as pd

    from schemas.recording import ACCEL, GYRO
    from tasks.model.model import predict
    from tasks.model.terms.standard import STANDARD_TERMS
    from tasks.motion.whole import whole_motion

    known = {term.name: term for term in reversed((*STANDARD_TERMS, *terms(recording)))}
    given = {
        (name, key): value for name, own in (values or {}).items() for key, value in own.items()
    }
    chosen = {name: known[name] for name, _ in given if name in known}
    model = (*STANDARD_TERMS, *(each for each in chosen.values() if each not in STANDARD_TERMS))
    places = {(term.name, one.name): place for place, (term, one) in enumerate(
        (term, one) for term in model for one in term.parameters)}  # fmt: skip
    wrong = sorted(".".join(each) for each in given.keys() - places.keys())
    if wrong:
        raise Unusable(f"this recording has no {', '.join(wrong)}; see mimucal.terms")
    at = nominal_values(model)
    for each, value in given.items():
        at[places[each]] = value
    motion = whole_motion(recording)
    read = predict(model, motion, at)
    return pd.DataFrame(read, columns=[*GYRO, *ACCEL], index=pd.Index(motion.t, name="t"))
