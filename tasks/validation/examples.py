"""The worked examples of both Appendices A, computed by the code that prints them."""

from decimal import Decimal

from schemas.validation import Check
from tasks.uncertainty.examples import combine_as_example
from tasks.validation.record import checked
from tasks.words import message
from tasks.words.rounding import round_up

# The example's title, what is added up to u₃, and u_c and U as printed.
SCALE = ("A.1", (1.22e-4,), "2.12e-4", "4.3e-4")
BIAS = ("A.2", (3.41e-5,) * 6, "2.68e-4", "5.36e-4")
PAIR = ("A.3", (2.51e-3,) * 2, "5.02e-3", "1.1e-2")
ZERO = ("A.2", (3.41e-5,) * 4, "2.20e-4", "4.4e-4")
EXAMPLES = {
    "gyro_scale_factor": SCALE,
    "gyro_cross_coupling": SCALE,
    "gyro_fit_offset": SCALE,  # of the same straight line
    "gyro_bias": BIAS,
    "gyro_g_sensitivity": PAIR,
    "accel_scale_factor": SCALE,
    "accel_cross_coupling": SCALE,
    "accel_bias": BIAS,
    "accel_rate_sensitivity": PAIR,
    "ahrs_scale_factor": SCALE,
    "ahrs_zero_offset": ZERO,
    "ahrs_misalignment": PAIR,
}
DIGITS = 3


def example_check(item: str) -> Check:
    """Whether the example that an item's uncertainty follows comes out to its printed digits."""
    clause, components, u_c, U = EXAMPLES[item]
    specification = "JJF 1536-2015" if item.startswith("ahrs") else "JJF 2003-2022"
    budget = combine_as_example(item, "1", 0.0, components)
    printed = Decimal(repr(budget.U)) if len(U.split("e")[0]) > DIGITS else round_up(budget.U)
    passed = Decimal(repr(budget.u_c)) == Decimal(u_c) and printed == Decimal(U)
    return checked(
        passed,
        message(
            "validation-example", specification=specification, clause=clause, u_c=u_c, U=U,
            result=f"u_c = {budget.u_c:.2e}, U = {printed:.2e}",
        ),
    )  # fmt: skip
