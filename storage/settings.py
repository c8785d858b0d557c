"""What a laboratory writes itself, as TOML or JSON: limits, letterhead, orders, procedures."""

import json
import tomllib
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.calibration import Calibration
from schemas.certificate import Laboratory, Order
from schemas.procedure import Procedure
from schemas.station import StationFile
from schemas.tolerance import Tolerance
from schemas.validation import ValidationRecord
from storage.home import Home

LABORATORY = "laboratory.toml"
VALIDATION = "validation.json"
READERS = {".toml": tomllib.loads, ".json": json.loads}

Model = TypeVar("Model", bound=Frozen)


def read_tolerance(path: Path) -> Tolerance:
    """The limits of one product model; raises Unusable for a file that does not say them."""
    return _read(path, Tolerance)


def read_laboratory(path: Path) -> Laboratory:
    """The laboratory, its standards and who signs; raises Unusable for a bad file."""
    return _read(path, Laboratory)


def read_order(path: Path) -> Order:
    """The client's order; raises Unusable for a bad file."""
    return _read(path, Order)


def read_station(path: Path) -> StationFile:
    """A station to acquire from; raises Unusable for a bad file."""
    return _read(path, StationFile)


def read_calibration(path: Path) -> Calibration:
    """A result as `mimucal calibrate --json` prints it; raises Unusable for a bad file."""
    return _read(path, Calibration)


def read_procedure(path: Path) -> Procedure:
    """A procedure; raises Unusable for a bad file."""
    return _read(path, Procedure)


def tolerance_for(manufacturer: str, model: str, home: Home) -> Tolerance | None:
    """The limits of a product model, from the files in the home's `tolerances`.

    None when no file is about the model; raises
    Unusable when two are, or when any file there cannot be read: it may be the one.
    """
    found: dict[Path, Tolerance] = {}
    for path in sorted(home.tolerances.glob("*")):
        if path.suffix.lower() in READERS and not path.name.startswith("."):
            tolerance = read_tolerance(path)
            if same_model(tolerance, manufacturer, model):
                found[path] = tolerance
    if len(found) > 1:
        raise Unusable(
            f"{' and '.join(str(path) for path in found)} both hold limits of {manufacturer} "
            f"{model}; keep the one that counts."
        )
    return next(iter(found.values()), None)


def same_model(tolerance: Tolerance, manufacturer: str, model: str) -> bool:
    """Whether limits are those of a product model; case and space do not count in the names."""
    return _plain(tolerance.manufacturer, tolerance.model) == _plain(manufacturer, model)


def laboratory(home: Home) -> Laboratory | None:
    """The laboratory that the home belongs to, or None where `laboratory.toml` is missing."""
    path = home.path / LABORATORY
    return read_laboratory(path) if path.exists() else None


def validation(home: Home) -> ValidationRecord | None:
    """The record that `mimucal validate` left in the home, or None where there is none."""
    path = home.path / VALIDATION
    return _read(path, ValidationRecord) if path.exists() else None


def _plain(*names: str) -> tuple[str, ...]:
    return tuple(" ".join(name.split()).casefold() for name in names)


def _read(path: Path, model: type[Model]) -> Model:
    form = model.model_fields["format"].default
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise Unusable(f"{path} is neither .toml nor .json; write it as one of them ({form}).")
    try:
        fields = reader(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); see that it is there and may be read."
        ) from error
    except UnicodeDecodeError as error:
        raise Unusable(f"{path} is not UTF-8 (byte {error.start}); save it as UTF-8.") from error
    except (ValueError, RecursionError) as error:
        kind = path.suffix[1:].upper()
        raise Unusable(f"{path} is not {kind} ({error}); correct it there.") from error
    try:
        return model.model_validate(fields)
    except ValidationError as error:
        raise Unusable(f"{path}: {first_fault(error)}; correct it there ({form}).") from error
