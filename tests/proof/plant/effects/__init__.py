"""Every effect the plant can make, by name."""

from collections.abc import Mapping
from types import ModuleType

from tests.proof.plant.case import Case
from tests.proof.plant.effects import (
    accelerometer,
    electronics,
    environment,
    geometry,
    gyro,
    memory,
    outside_motion,
    outside_sensors,
    site,
    table,
    timing,
)
from tests.proof.plant.effects.base import Effect
from tests.proof.plant.world import Setting


def _effects(module: ModuleType) -> list[type[Effect]]:
    classes = [item for item in vars(module).values() if isinstance(item, type)]
    own = [item for item in classes if item.__module__ == module.__name__]
    return [item for item in own if issubclass(item, Effect)]


FAMILIES: dict[str, list[type[Effect]]] = {
    module.__name__.rsplit(".", 1)[1]: _effects(module)
    for module in (
        site, geometry, table, timing, gyro, accelerometer, environment, electronics, memory,
        outside_motion, outside_sensors,
    )
}  # fmt: skip
EFFECTS: dict[str, type[Effect]] = {
    effect.name: effect for family in FAMILIES.values() for effect in family
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
