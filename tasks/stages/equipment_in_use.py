"""The measurement standards used for a run, and what they state of its reference."""

import json
from datetime import date
from typing import Any

from pydantic import ValidationError

from schemas.certificate import Laboratory
from schemas.equipment import EquipmentLimit, LimitName, MeasurementStandard
from schemas.recording import Manifest, Recording
from storage.catalogue import equipment
from storage.catalogue.lineage import provenance
from storage.home import Home
from tasks.calibrate.reference import as_certified
from tasks.uncertainty.equipment import own_limits


def standards_in_use(
    listed: tuple[MeasurementStandard, ...], home: Home, day: date | None
) -> tuple[MeasurementStandard, ...]:
    """The listed standards, those of the register with the certificate that counts on a day."""
    registered = equipment.on_day(home, day) if listed else {}
    return tuple(registered.get(standard.serial, standard) for standard in listed)


def limits_in_use(
    manifest: Manifest, home: Home, laboratory: Laboratory | None
) -> dict[LimitName, EquipmentLimit]:
    """What the equipment of a run may be off by.

    What laboratory.toml states goes before the certificates of the standards, which are those that
    it lists, else those of the manifest. Raises Unusable for a drift since an unknown day.
    """
    standards, day = _standards_of(manifest, home, laboratory)
    return own_limits(standards, laboratory.limits if laboratory else {}, day)


def reference_in_use(recording: Recording, home: Home, laboratory: Laboratory | None) -> Recording:
    """The recording with its reference corrected by the certificates of the same standards.

    Raises Unusable for a run outside of what they state, see `as_certified`.
    """
    standards, _ = _standards_of(recording.manifest, home, laboratory)
    return as_certified(recording, standards, laboratory.limits if laboratory else ())


def _standards_of(
    manifest: Manifest, home: Home, laboratory: Laboratory | None
) -> tuple[tuple[MeasurementStandard, ...], date | None]:
    """The standards of a run, and the day on which they were used."""
    listed = laboratory.equipment if laboratory else ()
    day: date | None = provenance(manifest)["recorded_on"]
    return standards_in_use(listed or _of_manifest(manifest), home, day), day


def _of_manifest(manifest: Manifest) -> tuple[MeasurementStandard, ...]:
    """The standards that a manifest names; what is no such record is refused by `certify`."""
    named = (manifest.model_extra or {}).get("equipment")
    records = named if isinstance(named, list | tuple) else ()
    return tuple(standard for each in records if (standard := _standard(each)))


def _standard(record: Any) -> MeasurementStandard | None:
    try:
        return MeasurementStandard.model_validate_json(json.dumps(record))
    except ValidationError:
        return None
