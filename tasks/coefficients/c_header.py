"""A correction as a C header: constants, the correcting function, and an example to test it."""

from typing import Any

from schemas.correction import Correction
from tasks.coefficients.correct import PASSES
from tasks.coefficients.tables import heading

FORCES = ("accel", "force")
FUNCTION = """
/* Corrects one reading: gyro rad/s, accel m/s2 into rate rad/s, force m/s2. */
static inline void mimu_correct(const double gyro[3], const double accel[3],
                                double rate[3], double force[3])
{
    double squared[3] = {0.0, 0.0, 0.0};
    int pass, i, j;
    for (pass = 0; pass <= MIMU_PASSES; pass++) {
        double without[3];
        for (i = 0; i < 3; i++) {
            without[i] = accel[i] - MIMU_B_a[i];
            for (j = 0; j < 3; j++)
                without[i] -= MIMU_P[i][j] * squared[j];
        }
        for (i = 0; i < 3; i++) {
            force[i] = 0.0;
            for (j = 0; j < 3; j++)
                force[i] += MIMU_C_a[i][j] * without[j];
        }
        if (pass == MIMU_PASSES)
            return;
        for (i = 0; i < 3; i++) {
            without[i] = gyro[i] - MIMU_B_g[i];
            for (j = 0; j < 3; j++)
                without[i] -= MIMU_G[i][j] * force[j];
        }
        for (i = 0; i < 3; i++) {
            rate[i] = 0.0;
            for (j = 0; j < 3; j++)
                rate[i] += MIMU_C_g[i][j] * without[j];
        }
        for (i = 0; i < 3; i++)
            squared[i] = rate[i] * rate[i];
    }
}
"""


def as_c(correction: Correction) -> str:
    """A header for C99 and C++; doubles are written so that they are read back as they are."""
    comment = heading(correction, " * ").replace("*/", "* /").replace("/*", "/ *")
    constants = [
        _array(f"MIMU_{name}", coefficient.value, coefficient.unit)
        for name, coefficient in correction.coefficients.items()
    ]
    example = [
        _array(f"MIMU_EXAMPLE_{name.upper()}", value, "m/s2" if name in FORCES else "rad/s")
        for name, value in correction.example
    ]
    return "\n".join([
        f"/*\n{comment} */",
        "#ifndef MIMU_CORRECTION_H\n#define MIMU_CORRECTION_H\n",
        f"#define MIMU_PASSES {PASSES}\n",
        *constants,
        FUNCTION,
        "/* mimu_correct(MIMU_EXAMPLE_GYRO, MIMU_EXAMPLE_ACCEL, ...) gives these. */",
        *example,
        "\n#endif\n",
    ])  # fmt: skip


def _array(name: str, values: tuple[Any, ...], unit: str) -> str:
    if isinstance(values[0], tuple):
        rows = ",\n".join(f"    {_braced(row)}" for row in values)
        return f"static const double {name}[3][3] = {{ /* {unit} */\n{rows}\n}};"
    return f"static const double {name}[3] = {_braced(values)}; /* {unit} */"


def _braced(values: tuple[float, ...]) -> str:
    return f"{{{', '.join(map(repr, values))}}}"
