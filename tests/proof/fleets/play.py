"""A run of a fleet as a recording that tells who, where and when, and nothing of the truth."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

from schemas.recording import Manifest, Recording
from tests.proof.fleets.draw import Fleet, FleetRun
from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import manifest_of, simulate

BEGINNING = datetime(2025, 3, 1, 8, tzinfo=UTC)


def played(fleet: Fleet, run: FleetRun) -> Recording:
    """The recording of a run."""
    recording = simulate(fleet.case_of(run)).recording
    return replace(recording, manifest=manifest_of_run(fleet, run))


def manifest_of_run(fleet: Fleet, run: FleetRun) -> Manifest:
    """Its manifest, with the names that the fleet has for unit, model, station and site."""
    case = fleet.case_of(run)
    declared = manifest_of(case, plan_of(case)).model_dump(mode="json", exclude_none=True)
    declared["recording_id"] = f"fleet_{fleet.number}_{run.day:04d}"
    declared["acquired_at"] = (BEGINNING + timedelta(days=run.day)).isoformat()
    declared["unit"] |= {"serial": unit_name(run.unit), "model": model_name(fleet.models[run.unit])}
    declared["station"] |= {
        "id": station_name(run.station), "site": site_name(fleet.sites[run.station])
    }  # fmt: skip
    return Manifest.model_validate(declared)


def carrier_name(fleet: Fleet) -> str:
    """The name of what carries the effect."""
    names = {"unit": unit_name, "station": station_name, "model": model_name, "site": site_name}
    return names[fleet.level](fleet.carrier)


def unit_name(number: int) -> str:
    return f"SN{number:04d}"


def station_name(number: int) -> str:
    return f"ST-{number:02d}"


def model_name(number: int) -> str:
    return f"M{number}"


def site_name(number: int) -> str:
    return f"site {number}"
