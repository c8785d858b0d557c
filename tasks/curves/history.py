"""How the coefficients of a unit changed between its certificates."""

from collections.abc import Iterator, Sequence

from schemas.certificate import Certificate
from schemas.curve import MAX_POINTS, Curve
from schemas.recording import AXES
from tasks.curves.points import short
from tasks.specifications.register import SPECIFICATIONS


def history(present: Certificate, earlier: Sequence[Certificate]) -> Iterator[Curve]:
    """Each value by axis less that of the present certificate, over days since its calibration.

    earlier: issued certificates of the same unit, of which those by the same method with an
    earlier day of calibration count; the last point is the present one.
    """
    day, result = present.calibrated_on, present.calibration
    if day is None:
        return
    dated = sorted(
        ((each.calibrated_on, each.number, each.calibration) for each in earlier
         if each.calibrated_on and each.calibrated_on < day
         and each.calibration.method == result.method),
        key=lambda one: one[:2],
    )[1 - MAX_POINTS :]  # fmt: skip
    specification = SPECIFICATIONS[result.method]
    for item in specification.items:
        now = result.items.get(item.key)
        if now is None or item.elements != AXES or item.key not in specification.required:
            continue
        for axis in AXES:
            value, U = now.value.get(axis), now.U.get(axis)
            before = [
                (number, float((when - day).days), was, was_U)
                for when, number, each in dated
                if item.key in each.items
                and (was := each.items[item.key].value.get(axis)) is not None
                and (was_U := each.items[item.key].U.get(axis)) is not None
            ]
            if value is None or U is None or not before:
                continue
            numbers, days, values, expanded = zip(*before, strict=True)
            yield Curve(
                figure="history", quantity=item.key, axis=axis, x_unit="d", y_unit=item.unit,
                x=(*days, 0.0), y=short((*(was - value for was in values), 0.0)),
                U=short((*expanded, U)), k=now.k, labels=numbers,
            )  # fmt: skip
