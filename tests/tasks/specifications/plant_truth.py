"""What a calibration of a simulated recording is off the recording's truth."""

import json

import numpy as np

from schemas.calibration import Calibration
from tests.shared import shared_path

TRUTH_KEYS = {
    "gyro_scale_factor": "Kg", "gyro_cross_coupling": "Kg", "gyro_bias": "Bg",
    "gyro_g_sensitivity": "G", "accel_scale_factor": "Ka", "accel_cross_coupling": "Ka",
    "accel_bias": "Ba", "accel_rate_sensitivity": "P",
}  # fmt: skip


def off_the_truth(name: str, found: Calibration, gravity: float) -> dict[str, float]:
    """(value − truth)/u of every element that truth.json knows."""
    path = shared_path(f"data/plant/{name}/truth.json")
    parameters = json.loads(path.read_text())["parameters"]
    truth = {key: np.array(each) for key, each in parameters.items()}
    truth["Bg"], truth["G"] = np.degrees(truth["Bg"]), np.degrees(truth["G"]) * gravity
    off = {}
    for item_name, key in TRUTH_KEYS.items():
        item = found.items[item_name]
        for element, value in (item.value_model or item.value).items():
            place = tuple("xyz".index(letter) for letter in element)
            true = truth[key][place] if truth[key].ndim == len(place) else truth[key][place * 2]
            off[f"{item_name}.{element}"] = (value - true) / item.u[element]
    return off
