"""Faults that the station noticed itself and wrote into the manifest."""

from collections.abc import Iterator

from pydantic import TypeAdapter, ValidationError

from schemas.text import Remark, Statement
from tasks.run_validity.remark import run_remark
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import remark

FIELD = "station_remarks"
REMARKS = TypeAdapter(tuple[Remark, ...])
OF_TABLE = ("table_unsettled", "table_rate")  # codes of tasks.station.anomalies
OF_UNIT = ("stuck_channel", "spikes")


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
