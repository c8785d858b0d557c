"""The unit's clock against the table's, as kept in a station's recording (`unit_clock`)."""

from schemas.base import Finite, Frozen


class ClockComparison(Frozen):
    """Table time minus unit time = offset_s + skew · (unit time − at_s).

    `half_width_s`: by how much the least delays of the line and of the table's answers, which no
    comparison on one side of a line can tell, may have moved the offset either way.
    `u_offset_s`, `u_skew`: standard uncertainties. That of the offset is of this and of the scatter
    of the delays; that of the skew of the scatter alone, since the least delays are the same all
    along. How late a unit measures what it stamps is not in them.
    """

    at_s: Finite
    offset_s: Finite
    half_width_s: Finite
    u_offset_s: Finite
    skew: Finite
    u_skew: Finite
