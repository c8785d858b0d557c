"""How much a face may tilt: table angles halved by two headings, mountings whole."""

import pytest

from tasks.uncertainty.equipment import ARCSECOND, JJF2003, UNKNOWN
from tasks.uncertainty.type_b import tilt_of_a_face


def test_two_headings_halve_the_variance_of_the_table_angles_alone() -> None:
    third = ARCSECOND**2 / 3.0  # rectangular limits of 10″, 5″ (angles), 10″ (axes), 10″ (fixture)
    once = ((10.0**2 + 5.0**2) / 2.0 + 10.0**2) * third
    anew = once + 10.0**2 * third
    assert tilt_of_a_face(JJF2003, mounted_once=True) == pytest.approx(once, rel=1e-12, abs=0.0)
    assert tilt_of_a_face(JJF2003, mounted_once=False) == pytest.approx(anew, rel=1e-12, abs=0.0)
    assert tilt_of_a_face(UNKNOWN, mounted_once=False) == 0.0
