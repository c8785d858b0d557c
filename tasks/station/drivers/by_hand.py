"""The fixture turned by a person, who sees to the supply too and says when it is done."""

from schemas.procedure import Refix
from tasks.station.ports import Ask


class ByHand:
    """A fixture that asks."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask

    async def turn(self, refix: Refix) -> float | None:
        """Have it done; when the supply came back is not known."""
        await self._ask(refix)
        return None
