"""The measurement standards used for a run, and what they state of its reference."""

import json
from collections.abc import Container, Iterable, Iterator
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

# on which two documents may disagree
PAPER = ("certificate", "traceable", "calibrated_on", "valid_until")


def standards_in_use(
    manifest: Manifest, home: Home, laboratory: Laboratory | None, day: date | None
) -> tuple[MeasurementStandard, ...]:
    """The standards that a run names, else those that its laboratory lists.

    Those of the register with the certificate that counts on a day. What a run says is virtual
    stays so, whatever the register leaves out.
    """
    listed = of_manifest(manifest) or (laboratory.equipment if laboratory else ())
    registered = equipment.on_day(home, day) if listed else {}
    return tuple(
        registered.get(each.serial, each).model_copy(update={"virtual": True})
        if each.virtual
        else registered.get(each.serial, each)
        for each in listed
    )


def contradictions(
    manifest: Manifest, listed: Iterable[MeasurementStandard], home: Home, day: date | None
) -> tuple[str, ...]:
    """Contradictions between a run and laboratory.toml, or the register, on the standards it was
    measured with. None for a run that names no standard. A certificate that the register has
    renewed since the run is no contradiction.
    """
    used = {standard.serial: standard for standard in of_manifest(manifest)}
    if not used:
        return ()
    registered = equipment.on_day(home, day)
    found: list[str] = []
    for standard in listed:
        if own := used.get(standard.serial):
            found += _disputed(own, standard, "laboratory.toml", registered)
        else:
            found.append(
                f"laboratory.toml lists {standard.name} ({standard.serial}) as a measurement "
                f"standard, but the recording says that {', '.join(used)} were used"
            )
    for serial, own in used.items():
        if serial in registered:
            found += _disputed(own, registered[serial], "the register", registered)
    return tuple(dict.fromkeys(found))


def _disputed(
    own: MeasurementStandard, other: MeasurementStandard, paper: str, registered: Container[str]
) -> Iterator[str]:
    """The fields in which two records of one standard disagree on one certificate of it."""
    if own.certificate != other.certificate and own.serial in registered:
        return
    pairs: list[tuple[str, Any, Any]] = [
        (name, getattr(own, name), getattr(other, name)) for name in PAPER
    ]
    pairs += [
        (f"limits.{name}", own.limits[name].half_width, other.limits[name].half_width)
        for name in own.limits.keys() & other.limits.keys()
    ]
    for name, recorded, stated in pairs:
        if None not in (recorded, stated) and recorded != stated:
            yield (
                f"{own.name} ({own.serial}): the recording says {name} = {_written(recorded)}, "
                f"but {paper} says {_written(stated)}"
            )


def _written(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value}"


def limits_in_use(
    manifest: Manifest, home: Home, laboratory: Laboratory | None
) -> dict[LimitName, EquipmentLimit]:
    """The error limits of the equipment of a run. Those in laboratory.toml take precedence over the
    certificates of the standards in use. Raises Unusable for a drift since an unknown day.
    """
    day = _day(manifest)
    standards = standards_in_use(manifest, home, laboratory, day)
    return own_limits(standards, laboratory.limits if laboratory else {}, day)


def reference_in_use(recording: Recording, home: Home, laboratory: Laboratory | None) -> Recording:
    """The recording with its reference corrected by the certificates of the same standards.

    Raises Unusable for a run outside of what they state, see `as_certified`.
    """
    manifest = recording.manifest
    standards = standards_in_use(manifest, home, laboratory, _day(manifest))
    return as_certified(recording, standards, laboratory.limits if laboratory else ())


def _day(manifest: Manifest) -> date | None:
    """The day on which a run used its standards."""
    day: date | None = provenance(manifest)["recorded_on"]
    return day


def of_manifest(manifest: Manifest) -> tuple[MeasurementStandard, ...]:
    """The standards named in a manifest; `certify` refuses malformed records."""
    named = (manifest.model_extra or {}).get("equipment")
    records = named if isinstance(named, list | tuple) else ()
    return tuple(standard for each in records if (standard := _standard(each)))


def _standard(record: Any) -> MeasurementStandard | None:
    try:
        return MeasurementStandard.model_validate_json(json.dumps(record))
    except ValidationError:
        return None
