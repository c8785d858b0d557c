"""All checks of a run."""

from collections.abc import Mapping

from schemas.calibration import Item
from schemas.text import Remark
from tasks.run_validity.clocks import clock_remarks
from tasks.run_validity.encoders import encoder_remarks
from tasks.run_validity.environment import environment_remarks
from tasks.run_validity.labels import label_remarks
from tasks.run_validity.lost_data import lost_data_remarks
from tasks.run_validity.outliers import outlier_remarks
from tasks.run_validity.points import point_remarks
from tasks.run_validity.scatter import scatter_remarks
from tasks.run_validity.site import site_remarks
from tasks.run_validity.station_faults import station_remarks
from tasks.run_validity.supply import supply_remarks
from tasks.run_validity.unit_temperature import unit_temperature_remarks
from tasks.run_validity.vibration import vibration_remarks
from tasks.segments.conditions import Conditions
from tasks.specifications.evidence import ClauseEvidence


def run_remarks(
    evidence: ClauseEvidence, conditions: Conditions, items: Mapping[str, Item]
) -> tuple[Remark, ...]:
    """All remarks on a run, family by family.

    items: by whose uncertainties a drift is judged.
    """
    return (
        *label_remarks(evidence, conditions),
        *encoder_remarks(evidence),
        *site_remarks(evidence),
        *outlier_remarks(evidence),
        *vibration_remarks(evidence),
        *scatter_remarks(evidence, items),
        *lost_data_remarks(evidence),
        *clock_remarks(evidence),
        *point_remarks(evidence, conditions),
        *environment_remarks(evidence, conditions),
        *unit_temperature_remarks(evidence),
        *supply_remarks(evidence),
        *station_remarks(evidence),
    )
