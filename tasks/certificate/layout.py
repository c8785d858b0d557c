"""The inner pages by method: which items stand where, and what their specification lays down.

Order of Appendix B of JJF 2003-2022 and of Appendix C of JJF 1536-2015. The texts stand in the
catalogues under the keys of specification and method.
"""

from dataclasses import dataclass, replace

from schemas.calibration import Method


@dataclass(frozen=True)
class Layout:
    """The pages of one method.

    key: of the specification in the catalogues; specification: its name, as clauses begin.
    sections: key of the title and items. items: those the specification asks for. two_values:
    items that show a second value. conditions: the fields on how it was measured, in order.
    """

    method: Method
    key: str
    specification: str
    sections: tuple[tuple[str, tuple[str, ...]], ...]
    items: tuple[str, ...]
    two_values: tuple[str, ...]
    temperature: str
    humidity: str
    conditions: tuple[str, ...]


JJF2003 = Layout(
    method="jjf2003",
    key="jjf2003",
    specification="JJF 2003-2022",
    sections=(
        ("scale-factors", ("gyro_scale_factor", "accel_scale_factor", "gyro_fit_offset")),
        ("biases", ("gyro_bias", "accel_bias")),
        ("gyro-cross-coupling", ("gyro_cross_coupling",)),
        ("accel-cross-coupling", ("accel_cross_coupling",)),
        ("g-sensitivity", ("gyro_g_sensitivity",)),
        ("rate-sensitivity", ("accel_rate_sensitivity",)),
    ),
    items=(  # Table 2
        "gyro_scale_factor", "gyro_bias", "gyro_g_sensitivity", "gyro_cross_coupling",
        "accel_bias", "accel_scale_factor", "accel_cross_coupling", "accel_rate_sensitivity",
    ),
    two_values=("gyro_g_sensitivity", "accel_rate_sensitivity"),
    temperature="(20 ± 5) °C",  # clause 6
    humidity="20 % … 85 %",
    conditions=("dwell", "positions", "attitudes", "mounting"),
)  # fmt: skip
JOINT = replace(JJF2003, method="joint", two_values=("accel_rate_sensitivity",))
JJF1536 = Layout(
    method="jjf1536",
    key="jjf1536",
    specification="JJF 1536-2015",
    sections=(
        ("ahrs-scale-factors", ("ahrs_scale_factor",)),
        ("zero-offsets", ("ahrs_zero_offset",)),
        ("misalignments", ("ahrs_misalignment",)),
    ),
    items=("ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment"),  # clause 7
    two_values=(),
    temperature="(20 ± 3) °C",  # clause 6.2.1
    humidity="30 % … 85 %",
    conditions=("dwell", "positions", "zero-positions", "turns", "attitudes", "mounting"),
)
LAYOUTS = {layout.method: layout for layout in (JJF2003, JOINT, JJF1536)}
