"""The chamber: its air ramps to a set-point and stays there."""

from schemas.limits import ChamberLimits

MINUTE_S = 60.0


class VirtualChamber:
    """Starts at the temperature of the air and stays there until commanded otherwise."""

    def __init__(self, design: ChamberLimits, degc: float) -> None:
        self._rate = design.rate_k_min / MINUTE_S
        self.target = degc
        self._since_s, self._from = 0.0, degc

    def go_to(self, now_s: float, degc: float) -> None:
        """Sets out for a temperature from where the air is."""
        self._from, self._since_s = self.degc(now_s), now_s
        self.target = degc

    def degc(self, now_s: float) -> float:
        """Of the air at a station time (s)."""
        way = self._rate * (now_s - self._since_s)
        return self._from + min(max(self.target - self._from, -way), way)
