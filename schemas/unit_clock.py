"""The unit's clock against the table's, as kept in a station's recording (`unit_clock`)."""

from schemas.base import Finite, Frozen


class ClockComparison(Frozen):
    """Table time minus unit time = offset_s + skew · (unit time − at_s).

    `half_width_s`: how far the minimum delays of the line and of the table's answers may have
    shifted the offset either way; comparison at one end of a line cannot show them. `u_offset_s`,
    `u_skew`: standard uncertainties. That of the offset contains this half-width and the scatter of
    the delays; that of the skew only the scatter, since the minimum delays are constant. The delay
    between a unit's measurement and its time stamp is not included.
    """

    at_s: Finite
    offset_s: Finite
    half_width_s: Finite
    u_offset_s: Finite
    skew: Finite
    u_skew: Finite
