"""The catalogue of physics that the standard's model leaves out.

Every file of `tasks.model.terms` with a function `candidates(recording, motion)` is in it: adding
physics is adding one file.
"""

from importlib import import_module
from pkgutil import iter_modules

from schemas.recording import Recording
from tasks.model import terms
from tasks.model.term import Term
from tasks.motion.whole import Motion


def catalogue(recording: Recording, motion: Motion) -> tuple[Term, ...]:
    """Every term that this recording could need.

    motion: at even times (25 Hz or more) of the whole recording, t from its start, with the
    table's axes and the recorded signals where there are any. Variants of one effect (an order, a
    time constant) have the same name and differ in `at`.
    """
    names = sorted(module.name for module in iter_modules(terms.__path__))
    modules = (import_module(f"{terms.__name__}.{name}") for name in names)
    return tuple(
        term
        for module in modules
        if hasattr(module, "candidates")
        for term in module.candidates(recording, motion)
    )
