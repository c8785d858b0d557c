"""Explains a recording in a process that has its folder and nothing else.

Imports nothing of the plant, and knows of the truth neither file nor form.
"""

import json
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import Recording
from storage.formats.folder import read_folder
from tasks.calibrate.calibrate import calibrate
from tasks.explain.correction.adopt import adopt
from tasks.explain.explain import explain
from tasks.explain.explanation import CHANNELS, Explanation
from tasks.specifications.register import specification_for
from tasks.words import say
from tests.proof.study import answers

# What a certificate by the clauses states, of the readings as they are and less what was found.
#
# Imports nothing of the plant: the processes that explain write it, too.

CERTIFICATE = "certificate.json"
UNNAMED = "unnamed"
SCATTER = "excess_scatter"  # the remark of a residual beyond the noise, at 1 %


def certificate_of(recording: Recording) -> dict[str, Any] | None:
    """The clauses' items of a recording; None where it gives none.

    values: [value, U] by item and element. scatter: how many remarks say that residuals are
    beyond the noise, which is all that the clauses' own evaluation would notice.
    """
    try:
        return _stated(_by_clauses(recording))
    except Unusable:
        return None


def certificate_less(recording: Recording, explanation: Explanation) -> dict[str, Any] | None:
    """The same with what was found and named taken off first, as `calibrate --terms` does.

    What is unnamed cannot be ordered taken off, and stays. None where there is nothing to take
    off, or no item.
    """
    named = [finding for finding in explanation.findings if finding.effect != UNNAMED]
    if not named:
        return None
    try:
        return _stated(adopt(recording, named, _by_clauses, explanation.determined))
    except Unusable:
        return None


def _by_clauses(recording: Recording) -> Calibration:
    specification = specification_for(recording.manifest.standard)
    return calibrate(specification, recording, run="-", code_version="-")


def _stated(calibration: Calibration) -> dict[str, Any]:
    values = {
        f"{name} {element}": [value, item.U.get(element)]
        for name, item in calibration.items.items()
        for element, value in item.value.items()
        if value is not None and item.U.get(element)
    }
    return {"values": values, "scatter": sum(r.code == SCATTER for r in calibration.remarks)}


RECORDINGS, ANSWERS = "recordings", "answers"  # in the folder of a trial
ANSWER, PREDICTION = "answer.json", "prediction.parquet"


def answer(recording: Recording, folder: Path) -> None:
    """Explains a recording and writes answer.json, prediction.parquet (float32) and
    certificate.json to folder/.

    A failure is an answer, too: it says what was raised.
    """
    folder.mkdir(parents=True, exist_ok=True)
    explanation = None
    started = time.perf_counter()
    try:
        explanation = explain(recording)
    except Exception as failure:
        response: dict[str, Any] = {"failed": f"{type(failure).__name__}: {failure}"}
    else:
        response = as_data(explanation)
        _write_prediction(explanation, folder / PREDICTION)
    response["seconds"] = time.perf_counter() - started
    _write_json(response, folder / ANSWER)
    _write_json(_certificates(recording, explanation), folder / CERTIFICATE)


def _certificates(recording: Recording, explanation: Explanation | None) -> dict[str, Any]:
    """As read, and less what was found; a failure leaves the second out and says why."""
    response: dict[str, Any] = {"read": certificate_of(recording), "less": None}
    if explanation is not None:
        try:
            response["less"] = certificate_less(recording, explanation)
        except Exception as failure:
            response["failed"] = f"{type(failure).__name__}: {failure}"
    return response


def _write_json(response: dict[str, Any], path: Path) -> None:
    path.write_text(json.dumps(response, indent=1, ensure_ascii=False), encoding="utf-8")


def as_data(explanation: Explanation) -> dict[str, Any]:
    return {
        "verdict": explanation.verdict,
        "p_value": explanation.p_value,
        "findings": [
            {
                "effect": finding.effect,
                "indistinguishable_from": list(finding.indistinguishable),
                "group": list(finding.group),
                "common": [each.model_dump() for each in finding.common],
                "channels": [CHANNELS[c] for c in finding.channels],
                "parameters": [each.model_dump() for each in finding.parameters],
                "gain": finding.gain,
                "delta_bic": finding.delta_bic,
                "held_out_gain": finding.held_out_gain,
                "follows": say(finding.follows, "en") if finding.follows else None,
            }
            for finding in explanation.findings
        ],
    }


def _write_prediction(explanation: Explanation, path: Path) -> None:
    """<channel>_nominal and <channel>_found at every row of the unit's stream."""
    columns = {}
    for i, channel in enumerate(CHANNELS):
        columns[f"{channel}_nominal"] = explanation.nominal[:, i].astype(np.float32)
        columns[f"{channel}_found"] = explanation.found[:, i].astype(np.float32)
    pq.write_table(pa.table(columns), path, compression="zstd")


def explain_blind(folder: Path) -> None:
    """Answers every recording of a folder, in processes that know nothing else of it."""
    work = {each.name: each for each in sorted((folder / RECORDINGS).iterdir())}
    answers("explain blind", work, partial(_answered, folder / ANSWERS), folder)


def _answered(own: Path, recording: Path) -> None:
    answer(read_folder(recording), own / recording.name)
