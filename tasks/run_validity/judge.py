"""All checks of a run."""

from collections.abc import Iterator, Mapping

from pydantic import TypeAdapter, ValidationError

from schemas.calibration import Item
from schemas.text import Remark, Statement
from tasks.readings.plausibility import on_sight
from tasks.run_validity.clocks import (
    clock_remarks,
    encoder_remarks,
    lost_data_remarks,
    time_base_remarks,
)
from tasks.run_validity.labels import label_remarks, point_remarks
from tasks.run_validity.remark import code_remarks, field_remarks, run_remark
from tasks.run_validity.scatter import outlier_remarks, scatter_remarks, vibration_remarks
from tasks.run_validity.site import (
    environment_remarks,
    site_remarks,
    supply_remarks,
    unit_temperature_remarks,
)
from tasks.segments.find import Conditions
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import remark

FIELD = "station_remarks"
REMARKS = TypeAdapter(tuple[Remark, ...])
OF_TABLE = ("table_unsettled", "table_rate")  # codes of tasks.station.monitor
OF_UNIT = ("stuck_channel", "spikes")


def run_remarks(
    evidence: ClauseEvidence, conditions: Conditions, items: Mapping[str, Item]
) -> tuple[Remark, ...]:
    """All remarks on a run, family by family.

    items: by whose uncertainties a drift is judged. Where the recording cannot be what it says,
    that comes first, and its consequences are not listed.
    """
    of_all_rows = not evidence.accumulates and not any(s.left_out for s in evidence.segments)
    read = evidence.means if of_all_rows else None
    sight = on_sight(evidence.recording, evidence.labels, read)
    if evidence.may_stand_still:  # rounding is no fault of its log
        sight = tuple(one for one in sight if one.code != "coarse_log")
    is_wrong = any(one.run == "invalid" for one in sight)
    return (
        *sight,
        *(() if is_wrong else _of_readings(evidence, conditions, items)),
        *environment_remarks(evidence, conditions),
        *unit_temperature_remarks(evidence),
        *supply_remarks(evidence),
        *evidence.recording.put_right,
        *station_remarks(evidence),
        *field_remarks(evidence.recording.manifest),
    )


def _of_readings(
    evidence: ClauseEvidence, conditions: Conditions, items: Mapping[str, Item]
) -> Iterator[Remark]:
    """What labels, encoders and readings show of each other."""
    yield from label_remarks(evidence, conditions)
    yield from encoder_remarks(evidence)
    yield from site_remarks(evidence)
    yield from code_remarks(evidence)
    yield from outlier_remarks(evidence)
    yield from vibration_remarks(evidence)
    yield from scatter_remarks(evidence, items)
    yield from lost_data_remarks(evidence)
    yield from clock_remarks(evidence)
    yield from time_base_remarks(evidence)
    yield from point_remarks(evidence, conditions)


def station_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Faults of table and unit in measured segments; what else it noticed the data show."""
    noticed = (evidence.recording.manifest.model_extra or {}).get(FIELD, ())
    try:
        remarks = REMARKS.validate_python(noticed)
    except ValidationError:
        yield run_remark("station_remarks_unreadable", field=FIELD)
        return
    for each in remarks:
        if each.segments and each.code in (*OF_TABLE, *OF_UNIT):
            yield remark(
                each.code, Statement(en=each.en, zh=each.zh), each.segments, blocks_pass=True,
                run="invalid" if each.code in OF_TABLE else "remarks",
            )  # fmt: skip
