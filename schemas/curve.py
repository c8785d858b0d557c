"""Curves in a certificate's figures: a few points each, as drawn and as exported."""

from typing import Literal, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen
from schemas.recording import Axis

FigureName = Literal["rate-residuals", "tumble", "allan", "history"]
MAX_POINTS = 64


class Curve(Frozen):
    """The curve of one axis in a figure.

    quantity: the item or triad of its panel. U: k·u of each y. labels: for the tumble the axis that
    points up; for the history, except its last point, the certificates.
    """

    figure: FigureName
    quantity: str
    axis: Axis
    x_unit: str
    y_unit: str
    x: tuple[Finite, ...] = Field(min_length=1, max_length=MAX_POINTS)
    y: tuple[Finite, ...]
    U: tuple[Finite, ...]
    k: Finite
    labels: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _each_point_is_whole(self) -> Self:
        if not len(self.x) == len(self.y) == len(self.U) >= len(self.labels):
            raise ValueError(f"the curve {self.figure} {self.quantity} {self.axis} is not whole")
        return self
