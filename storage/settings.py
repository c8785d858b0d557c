"""Files that a laboratory writes itself, as TOML or JSON: limits, letterhead, orders,
procedures.
"""

import json
import tomllib
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from schemas.access import PagesFile
from schemas.base import Frozen, Unusable, first_fault
from schemas.calibration import ValidationRecord
from schemas.certificate import Laboratory
from schemas.orders import QualityFile
from schemas.store import RecallFile
from schemas.tolerance import Tolerance
from storage.home import Home
from storage.whole_files import check_depth, text_bytes

LABORATORY = "laboratory.toml"
REMINDERS = "recall.toml"
PAGES = "pages.toml"
QUALITY = "quality.toml"
VALIDATION = "validation.json"
READERS = {".toml": tomllib.loads, ".json": json.loads}

Model = TypeVar("Model", bound=Frozen)


def text_of(path: Path) -> str:
    """The text of a file; raises Unusable for one that is not there, or not UTF-8."""
    try:
        return text_bytes(path).decode("utf-8-sig")
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); check that it exists and is readable."
        ) from error
    except UnicodeDecodeError as error:
        raise Unusable(f"{path} is not UTF-8 (byte {error.start}); save it as UTF-8.") from error


def read(path: Path, model: type[Model]) -> Model:
    """A file of a laboratory's own: limits, letterhead, order, station, procedure, result.

    Raises Unusable for one that is not there, not UTF-8, not TOML or JSON, or not of the model's
    format.
    """
    form = model.model_fields["format"].default
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise Unusable(f"{path} is neither .toml nor .json; write it as one of them ({form}).")
    text = text_of(path)
    try:
        fields = reader(text)
        check_depth(fields)
    except (ValueError, RecursionError) as error:
        kind = path.suffix[1:].upper()
        raise Unusable(f"{path} is not {kind} ({error}); correct it there.") from error
    try:
        return model.model_validate(fields)
    except ValidationError as error:
        raise Unusable(f"{path}: {first_fault(error)}; correct it there ({form}).") from error


def tolerance_for(manufacturer: str, model: str, home: Home) -> Tolerance | None:
    """The limits of a product model, from the files in the home's `tolerances`.

    None when no file is about the model. Raises Unusable when two are, or when any file there
    cannot be read: it may be the one.
    """
    of_model: dict[Path, Tolerance] = {}
    for path in sorted(home.tolerances.glob("*")):
        if path.suffix.lower() in READERS and not path.name.startswith("."):
            tolerance = read(path, Tolerance)
            if same_model(tolerance, manufacturer, model):
                of_model[path] = tolerance
    if len(of_model) > 1:
        raise Unusable(
            f"{' and '.join(str(path) for path in of_model)} both hold limits of {manufacturer} "
            f"{model}; keep the one that counts."
        )
    return next(iter(of_model.values()), None)


def same_model(tolerance: Tolerance, manufacturer: str, model: str) -> bool:
    """Whether limits are those of a product model; case and space do not count in the names."""
    return _plain(tolerance.manufacturer, tolerance.model) == _plain(manufacturer, model)


def laboratory(home: Home) -> Laboratory | None:
    """The laboratory that the home belongs to, or None where `laboratory.toml` is missing."""
    path = home.path / LABORATORY
    return read(path, Laboratory) if path.exists() else None


def reminders(home: Home) -> RecallFile | None:
    """Who is reminded of recalibration and how, or None where `recall.toml` is missing."""
    path = home.path / REMINDERS
    return read(path, RecallFile) if path.exists() else None


def pages(home: Home) -> PagesFile:
    """How the operations pages are served; as usual where `pages.toml` is missing."""
    path = home.path / PAGES
    return read(path, PagesFile) if path.exists() else PagesFile()


def quality(home: Home) -> QualityFile:
    """Which units are golden; none where `quality.toml` is missing."""
    path = home.path / QUALITY
    return read(path, QualityFile) if path.exists() else QualityFile()


def validation(home: Home) -> ValidationRecord | None:
    """The record that `mimucal validate` left in the home, or None where there is none."""
    path = home.path / VALIDATION
    return read(path, ValidationRecord) if path.exists() else None


def _plain(*names: str) -> tuple[str, ...]:
    return tuple(" ".join(name.split()).casefold() for name in names)
