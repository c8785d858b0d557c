"""Every effect the plant can make, by name."""

from collections.abc import Mapping

from tests.proof.plant.case import Case
from tests.proof.plant.effects import (
    electronics,
    environment,
    memory,
    outside,
    sensors,
    setup,
)
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.world import Setting

EFFECTS: dict[str, type[Effect]] = {
    item.name: item
    for module in (setup, sensors, environment, electronics, memory, outside)
    for item in vars(module).values()
    if isinstance(item, type) and item.__module__ == module.__name__ and hasattr(item, "name")
}
CATALOGUE = tuple(name for name in EFFECTS if not name.startswith("x_"))
OUTSIDE = tuple(name for name in EFFECTS if name.startswith("x_"))


def effects_of(
    case: Case, setting: Setting, known: Mapping[str, type[Effect]] = EFFECTS
) -> tuple[Effect, ...]:
    """The effects of a case, with their parameters. known: every effect that it may name.

    Raises ValueError for a name the plant does not know, one that stands twice, or an effect
    that the procedure cannot have.
    """
    names = [call.name for call in case.effects]
    for name in names:
        if name not in known:
            raise ValueError(f"the plant has no effect {name}; it has {', '.join(known)}")
        if names.count(name) > 1:
            raise ValueError(f"the effect {name} stands twice in the case; give it once")
    return tuple(known[call.name].of(call, setting) for call in case.effects)
