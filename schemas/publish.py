"""The published JSON schemas: `python -m schemas.publish` writes them into schemas/json."""

import json
from pathlib import Path

from pydantic import BaseModel

from schemas.calibration import Budget, Calibration, Correction, EvidenceFile, ValidationRecord
from schemas.certificate import Certificate, Laboratory, Order
from schemas.discrepancy import Discrepancy, NextRecording
from schemas.history import Impact, Pruned, Reprocessing
from schemas.laboratory import EquipmentFile
from schemas.procedure import Procedure
from schemas.recording import Manifest
from schemas.station import StationFile
from schemas.store import Diagnosis, RecallFile
from schemas.tolerance import Tolerance

FOLDER = Path(__file__).parent / "json"
PUBLISHED: dict[str, type[BaseModel]] = {
    "mimu-recording": Manifest,
    "mimu-station": StationFile,
    "mimu-procedure": Procedure,
    "mimu-calibration": Calibration,
    "mimu-correction": Correction,
    "mimu-evidence": EvidenceFile,
    "mimu-budget": Budget,
    "mimu-tolerance": Tolerance,
    "mimu-laboratory": Laboratory,
    "mimu-order": Order,
    "mimu-equipment": EquipmentFile,
    "mimu-recall": RecallFile,
    "mimu-certificate-record": Certificate,
    "mimu-validation": ValidationRecord,
    "mimu-discrepancy": Discrepancy,
    "mimu-reprocess": Reprocessing,
    "mimu-impact": Impact,
    "mimu-prune": Pruned,
    "mimu-doctor": Diagnosis,
    "mimu-next": NextRecording,
}


def schema_text(model: type[BaseModel]) -> str:
    """The JSON schema of a model as it is written out, as the file's text."""
    schema = model.model_json_schema(mode="serialization")
    return json.dumps(schema, ensure_ascii=False, indent=1) + "\n"


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name, model in PUBLISHED.items():
        (FOLDER / f"{name}.json").write_text(schema_text(model), encoding="utf-8")


if __name__ == "__main__":
    main()
