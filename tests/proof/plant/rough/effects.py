"""Every effect that a rough recording may hide, by the name that a case gives it.

Most names are the catalogue's; another form of an effect has its own name here, and the
catalogue's in `name`.
"""

from types import ModuleType

from tests.proof.plant.effects import EFFECTS, effects_of
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.rough import firmware, forms_memory, forms_sensors, log_rows, outside
from tests.proof.plant.rough.logged import Logged
from tests.proof.plant.rough.runs import RoughSetting

MODULES = (firmware, log_rows, forms_memory, forms_sensors, outside)


def _forms(module: ModuleType) -> dict[str, type[Effect]]:
    classes = [item for item in vars(module).values() if isinstance(item, type)]
    own = [item for item in classes if item.__module__ == module.__name__]
    return {vars(item)["form"]: item for item in own if "form" in vars(item)}


FORMS: dict[str, type[Effect]] = {
    form: effect for module in MODULES for form, effect in _forms(module).items()
}
KNOWN: dict[str, type[Effect]] = EFFECTS | FORMS


def catalogue_name(called: str) -> str:
    """The name that a report would give the effect; x_… outside the catalogue."""
    return KNOWN[called].name


def rough_effects(setting: RoughSetting) -> tuple[Effect, ...]:
    """The effects of a case, those on the log in the order in which they act.

    Raises ValueError for a name that is not known, one that stands twice, or an effect that the
    run cannot have.
    """
    effects = effects_of(setting.case, setting, KNOWN)
    order = {form: place for place, form in enumerate(FORMS)}
    return tuple(sorted(effects, key=lambda e: order[e.form] if isinstance(e, Logged) else -1))
