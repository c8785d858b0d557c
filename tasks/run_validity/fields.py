"""Fields of the manifest that nothing reads and that are spelled nearly like one that is absent."""

from collections.abc import Iterator
from difflib import get_close_matches
from itertools import chain

from pydantic import BaseModel

from schemas.recording import Manifest
from schemas.text import Remark
from tasks.run_validity.remark import run_remark

ALIKE = 0.85  # similarity of two spellings of one name, by difflib


def field_remarks(manifest: Manifest) -> Iterator[Remark]:
    """What others wrote into a manifest is kept, so that a misspelt field is taken for theirs.

    It may be theirs, and then no unit is to fail for it.
    """
    within = [("", manifest), ("unit.", manifest.unit), ("station.", manifest.station),
              ("mount.", manifest.mount)]  # fmt: skip
    segments = (("segments.", segment) for segment in manifest.segments or ())
    found = dict(chain.from_iterable(_misspelt(*each) for each in chain(within, segments)))
    for field, meant in found.items():
        yield run_remark("misspelt_field", run="valid", field=field, meant=meant)


def _misspelt(place: str, model: BaseModel) -> Iterator[tuple[str, str]]:
    # By value: a manifest in store has the defaults of fields that nobody wrote.
    absent = [
        name
        for name, field in type(model).model_fields.items()
        if not field.is_required() and getattr(model, name) == field.get_default()
    ]
    for name in model.model_extra or ():
        for meant in get_close_matches(name, absent, n=1, cutoff=ALIKE):
            if not name.startswith(meant):  # rate_deg_s2 is another quantity
                yield place + name, place + meant
