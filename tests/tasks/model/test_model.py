"""The catalogue holds what the contract names, says it in both languages, and is open."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tasks.model import terms
from tasks.model.catalogue import catalogue
from tasks.model.model import linearise, predict
from tasks.model.term import (
    EVENTS,
    Effect,
    Term,
    effect_name,
    next_step,
    nominal_values,
    parameters_of,
)
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.model.terms.timing import ACCEL_AXIS_SKEW, TIME_OFFSET
from tasks.words import say
from tests.shared import shared_path
from tests.tasks.model.model_unit import GRAVITY, tumbling
from tests.tasks.model.table_run import T, motion, recording

TERMS = catalogue(recording(), motion())
NAMES = {term.name for term in TERMS} | set(EVENTS)
FAMILIES = {
    "site", "geometry", "table", "time", "gyro", "accelerometer", "environment", "electronics",
    "memory", "logger and firmware",
}  # fmt: skip


def of_each_name() -> list[Term]:
    return list({term.name: term for term in TERMS}.values())


def contract() -> dict[str, str]:
    """Name -> family of the contract's tables."""
    found, family = {}, ""
    tables = ("contracts/discrepancy.md", "contracts/discrepancy-rough.md")
    text = [shared_path(table).read_text(encoding="utf-8") for table in tables]
    for line in "\n".join(text).splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        names = re.findall(r"`(\w+)`", cells[2]) if len(cells) == 5 else []
        family = (cells[1] or family) if names else family
        found |= dict.fromkeys(names, family)
    return found


def test_the_contracts_names_are_there_with_their_families():
    families = {term.name: term.family for term in TERMS}
    families |= {event.name: event.family for event in EVENTS.values()}
    expected = contract()
    assert len(expected) == 45
    of_no_table = {"unnamed", "reference_frame"}
    assert {name: families.get(name) for name in expected if name not in of_no_table} == {
        name: family for name, family in expected.items() if name not in of_no_table
    }  # the catalogue is open: others may be there


@pytest.mark.parametrize("effect", [*of_each_name(), *EVENTS.values()], ids=lambda e: e.name)
def test_an_effect_is_described_in_both_languages(effect):
    todo = next_step(effect.name)
    assert effect.separated_by is not None
    assert todo is not None
    for sentence in (effect.title, effect.separated_by, todo, effect_name(effect.name)):
        assert re.sub("[²°]", "", say(sentence, "en")).isascii()
        assert re.search("[\u4e00-\u9fff]", say(sentence, "zh"))
    assert effect.equation
    assert effect.source
    assert effect.family in FAMILIES
    assert set(effect.confused_with) <= NAMES - {effect.name}
    assert effect.confused_with


def test_an_effect_without_an_entry_is_spelled_out():
    toy = Effect("toy_effect", "site", "event", "y = x", "a test")
    assert (toy.title, toy.separated_by, effect_name(toy.name)) == (
        "toy effect",
        None,
        "toy effect",
    )


@pytest.mark.parametrize("term", TERMS, ids=lambda t: f"{t.name}{t.at}")
def test_parameters_have_units_and_a_plausible_range_around_the_ideal(term):
    assert len(term.at) == len(term.shapes)
    assert len({parameter.name for parameter in term.parameters}) == len(term.parameters)
    for parameter in (*term.parameters, *term.shapes):
        low, high = parameter.plausible
        assert low < high
    assert all(low <= 0.0 <= high for low, high in (p.plausible for p in term.parameters))
    for value, shape in zip(term.at, term.shapes, strict=True):
        assert shape.plausible[0] <= value <= shape.plausible[1]


DEGREE, G = 0.017453292519943295, 9.80665  # rad; m/s²
# Of each printed unit the SI unit of the value, and how many of it that is; by hand.
IN_SI = {
    "deg": ("rad", DEGREE), "arcsec": ("rad", 4.84813681109536e-06),
    "deg/s": ("rad/s", DEGREE), "deg/h": ("rad/s", 4.84813681109536e-06),
    "(deg/s)/g": ("(rad/s)/g", DEGREE),  # of the standard's equation (1): force over local gravity
    "(deg/s)/g2": ("(rad/s)/(m/s2)2", DEGREE / G / G), "1/g": ("1/(m/s2)", 1.0 / G),
    "deg/g": ("rad/(m/s2)", DEGREE / G), "g/g2": ("(m/s2)/(m/s2)2", 1.0 / G),
    "(deg/s)/K": ("(rad/s)/K", DEGREE), "(deg/s)/V": ("(rad/s)/V", DEGREE),
    "(deg/s)/(K/s)": ("(rad/s)/(K/s)", DEGREE), "(deg/s)/mT": ("(rad/s)/T", DEGREE / 1e-3),
}  # fmt: skip


def test_every_unit_of_the_catalogue_is_that_of_its_value():
    sized = [free for term in TERMS if (free := term.with_free_size())]
    stated = (*TERMS, *sized, *STANDARD_TERMS)
    every = [p for term in stated for p in (*term.parameters, *term.shapes)]
    assert {p.unit for p in every if p.unit != p.si} == set(IN_SI)
    for p in every:
        si, size = IN_SI.get(p.unit, (p.unit, 1.0))
        assert p.si == si
        assert p.factor == pytest.approx(1.0 / size, rel=1e-12), p


@pytest.mark.parametrize(
    ("unit", "si"),
    [
        ("deg/fortnight", "rad/s"), ("gal", "m/s2"), ("deg/h", "rad"), ("g", "rad/s"),
        ("(deg/s)/g", "(rad/s)/(m/s2)2"), ("(deg/s", "rad/s"), ("m/s2", "SI"), ("", ""),
    ],
)  # fmt: skip
def test_a_term_with_an_unknown_or_another_unit_is_not_in_the_catalogue(
    unit, si, tmp_path, monkeypatch
):
    (tmp_path / "swell.py").write_text(
        "from tasks.model.term import single\n"
        f"SWELL = single('height', 'h', ({unit!r}, {si!r}, 1.0))\n"
        "def candidates(recording, motion):\n"
        "    return ()\n",
        encoding="utf-8",
    )
    monkeypatch.setattr(terms, "__path__", [*terms.__path__, str(tmp_path)])
    with pytest.raises(ValueError, match=r"unit|quantity"):
        catalogue(recording(), motion())


@pytest.mark.parametrize("term", [t for t in TERMS if t.parameters], ids=lambda t: t.name)
def test_an_ideal_unit_shows_nothing_of_an_effect(term):
    ideal = nominal_values(STANDARD_TERMS)
    with_it = predict((term, *STANDARD_TERMS), motion(), nominal_values((term, *STANDARD_TERMS)))
    assert np.abs(with_it - predict(STANDARD_TERMS, motion(), ideal)).max() < 1e-12


@pytest.mark.parametrize("term", [t for t in TERMS if t.shapes], ids=lambda t: f"{t.name}{t.at}")
def test_variants_of_one_effect_differ_in_their_shapes(term):
    same = [t for t in TERMS if (t.name, t.equation, t.at) == (term.name, term.equation, term.at)]
    assert len({tuple(p.name for p in t.parameters) for t in same}) == len(same)
    assert term.shaped(term.at) == term


def test_what_was_not_recorded_is_no_candidate():
    bare = replace(motion(), axes=None, recorded={}, north=np.full((len(T), 3), np.nan))
    missing = {t.name for t in TERMS} - {t.name for t in catalogue(recording(None), bare)}
    assert missing == {
        "earth_rotation", "axis_tilt", "axis_nonorthogonality", "axis_wobble", "rate_ripple",
        "encoder_eccentricity", "table_scale", "remount_misalignment",
        "temperature_bias", "temperature_scale", "thermal_gradient", "supply_sensitivity",
        "magnetic_sensitivity",
    }  # fmt: skip


def test_a_unit_that_never_turned_shows_nothing_of_turning():
    still = replace(motion(), rate=np.zeros((len(T), 3)), acceleration=np.zeros((len(T), 3)))
    names = {term.name for term in catalogue(recording(), still)}
    assert not names & {"lever_arm", "gyro_scale_asymmetry", "hysteresis", "structural_compliance"}
    assert {"gyro_g2_sensitivity", "accel_nonlinearity", "temperature_bias"} <= names


def test_one_file_more_is_one_effect_more(tmp_path, monkeypatch):
    (tmp_path / "tides.py").write_text(
        "from tasks.model.term import Term\n"
        "TIDE = Term('tide', 'site', 'input', 'g(t)', 'a test', ())\n"
        "def candidates(recording, motion):\n"
        "    return (TIDE,)\n",
        encoding="utf-8",
    )
    monkeypatch.setattr(terms, "__path__", [*terms.__path__, str(tmp_path)])
    added = [term.name for term in catalogue(recording(), motion())]
    assert sorted(added) == sorted([*(term.name for term in TERMS), "tide"])


def test_no_effect_behaves_by_its_name():
    for term in TERMS:
        for language in ("en", "zh"):
            behaviour = say(term.behaviour, language)
            assert behaviour not in (
                say(term.title, language),
                say(effect_name(term.name), language),
            )


# What terms predict, against the models of the standard written out.

MOTION = tumbling()
EARTH = 7.292115e-5


def drawn(terms: tuple, seed: int = 5) -> np.ndarray:
    ranges = np.array([p.plausible for p in parameters_of(terms)])
    return np.random.default_rng(seed).uniform(*(0.1 * ranges.T)) + nominal_values(terms)


def by_hand(values: np.ndarray, rate: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Models (1) and (2), row by row."""
    kg, bg, g = values[:9].reshape(3, 3), values[9:12], values[12:21].reshape(3, 3)
    ka, ba = values[21:30].reshape(3, 3), values[30:33]
    p = np.zeros((3, 3))
    p[~np.eye(3, dtype=bool)] = values[33:39]
    gyro = rate @ kg.T + bg + force @ g.T / GRAVITY
    return np.hstack([gyro, force @ ka.T + ba + rate**2 @ p.T])


def test_the_standard_terms_are_models_1_and_2():
    values = drawn(STANDARD_TERMS)
    expected = by_hand(values, MOTION.rate, GRAVITY * MOTION.up)
    assert predict(STANDARD_TERMS, MOTION, values) == pytest.approx(expected, abs=1e-12)


def test_earth_rotation_and_lever_arm_act_before_the_sensor():
    latitude, r = 0.6, np.array([0.02, -0.05, 0.01])
    terms = (earth_rotation(latitude), LEVER_ARM, *STANDARD_TERMS)
    values = drawn(STANDARD_TERMS)
    earth = EARTH * (np.cos(latitude) * MOTION.north + np.sin(latitude) * MOTION.up)
    rigid = [
        GRAVITY * up + np.cross(a, r) + np.cross(w, np.cross(w, r))
        for up, a, w in zip(MOTION.up, MOTION.acceleration, MOTION.rate, strict=True)
    ]
    # p follows what the gyros feel: ω with Earth's rotation in it.
    expected = by_hand(values, MOTION.rate + earth, np.array(rigid))
    read = predict(terms, MOTION, np.concatenate([r, values]))
    assert read[:, 3:] == pytest.approx(expected[:, 3:], abs=1e-10)
    assert read[:, :3] == pytest.approx(expected[:, :3], abs=1e-12)


def test_every_column_of_a_sensor_goes_through_the_delays_behind_it():
    terms = (*STANDARD_TERMS, ACCEL_AXIS_SKEW, TIME_OFFSET)
    values = drawn(terms)
    design = linearise(terms, MOTION, values)
    ahead = linearise(STANDARD_TERMS, MOTION, values[:-2])
    for before, behind in zip(ahead.columns, design.columns, strict=False):
        assert sorted(before) == sorted(behind)
        read = np.zeros((len(MOTION.t), 6))
        for channel, series in before.items():
            read[:, channel] = series
        for term, value in zip(terms[-2:], values[-2:], strict=True):
            read = term.passed(MOTION, read, np.array([value]))
        for channel, series in behind.items():
            assert series == pytest.approx(read[:, channel], abs=1e-12)


def test_where_north_is_unknown_only_the_vertical_part_of_earth_rotation_is_added():
    from dataclasses import replace

    blind = replace(MOTION, north=np.full_like(MOTION.north, np.nan))
    terms = (earth_rotation(0.6), *STANDARD_TERMS)
    ideal = nominal_values(terms)
    added = (predict(terms, blind, ideal) - predict(STANDARD_TERMS, blind, ideal))[:, :3]
    assert added == pytest.approx(EARTH * np.sin(0.6) * MOTION.up, abs=1e-15)
