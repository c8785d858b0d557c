"""The items of JJF 2003-2022 from the parameters of models (1) and (2)."""

from collections.abc import Mapping

from tasks.specifications.estimate import (
    DEG,
    Estimates,
    ItemEstimate,
    diagonal,
    off_diagonal,
    scaled,
    undetermined,
)
from tasks.specifications.evidence import ClauseEvidence

CLAUSES = {"gyro": "JJF 2003-2022, 5.1 eq. (1)", "accel": "JJF 2003-2022, 5.2 eq. (2)"}


def joint_items(
    evidence: ClauseEvidence,
    parameters: Mapping[str, Estimates],
    method: str,
    readings: Mapping[str, tuple[str, ...]],
) -> dict[str, ItemEstimate]:
    """The nine items, in the units of their results.

    parameters: by term, in SI units, with the fit offset beside them; method: as the clauses name
    it; readings: of each item.
    """
    gyro, accel = parameters["gyro_matrix"], parameters["accel_matrix"]
    elements = {
        "gyro_scale_factor": diagonal(gyro),
        "gyro_cross_coupling": off_diagonal(gyro),
        "gyro_fit_offset": scaled(parameters["gyro_fit_offset"], DEG),
        "gyro_bias": scaled(parameters["gyro_bias"], DEG),
        "gyro_g_sensitivity": scaled(parameters["gyro_g_sensitivity"], DEG),
        "accel_scale_factor": diagonal(accel),
        "accel_cross_coupling": off_diagonal(accel),
        "accel_bias": parameters["accel_bias"],
        "accel_rate_sensitivity": scaled(parameters["accel_rate_sensitivity"], -1.0),
    }
    without_earth = elements["gyro_g_sensitivity"]
    if evidence.latitude_deg is None:
        without_earth = undetermined(without_earth)
    return {
        key: ItemEstimate(
            of_item,
            f"{CLAUSES[key.partition('_')[0]]}, {method}",
            readings[key],
            without_earth if key == "gyro_g_sensitivity" else None,
        )
        for key, of_item in elements.items()
    }
