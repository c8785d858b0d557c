"""What the schemas refuse: functions of errors, orders, addresses with secrets."""

import math
from datetime import date
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from schemas.base import Unusable, escaped, filled, first_fault, has_secret, login_apart, shown
from schemas.laboratory import EquipmentLimit, MeasurementStandard
from schemas.orders import CalibrateOrder, CertifyOrder, ProduceOrder, WithdrawOrder, order_of
from schemas.tolerance import Limit, Tolerance
from storage.catalogue.database import name_of, url_of
from storage.home import Home

# Errors that a certificate states as a function: what is no such table is refused by its row.

ROWS = [{"at": 10.0, "deviation": 1e-5, "U": 1e-5}, {"at": 50.0, "deviation": 1e-5, "U": 1e-5}]
STANDARD = {"name": "T", "name_zh": "台", "serial": "1", "accuracy": "", "certificate": "C"}
CALIBRATED = {"calibrated_on": "2026-01-01"}
DRIFT = {"per_year": 1e-6, "distribution": "normal"}
POLYNOMIAL = {"coefficients": [1e-5], "lowest": 1.0, "highest": 2.0, "U": 1e-5}


def fault(name: str, **function: Any) -> str:
    more = function.pop("standard", {})
    with pytest.raises(ValidationError) as refused:
        MeasurementStandard.model_validate(
            STANDARD | {"functions": {name: {"deviation": "corrected"} | function}} | more
        )
    return first_fault(refused.value)


def test_a_table_is_taken_for_rate_and_position_and_one_row_for_gravity_and_time():
    one = {"deviation": "budgeted", "rows": [{"deviation": 0.0, "U": 1e-5}]}
    table = {"deviation": "corrected", "rows": ROWS, "drift": DRIFT}
    made = MeasurementStandard.model_validate(
        STANDARD
        | CALIBRATED
        | {"functions": {"rate": table, "position": table, "gravity": one, "time_base": one}}
    )
    assert MeasurementStandard.model_validate_json(made.model_dump_json()) == made


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        ({"rows": []}, "either rows or polynomials"),
        ({"rows": ROWS, "polynomials": [POLYNOMIAL]}, "either rows or polynomials"),
        ({"rows": [*ROWS, ROWS[0]]}, "row at = 10 follows at = 50: sort the rows"),
        ({"rows": [ROWS[0], ROWS[0]]}, "row at = 10 follows at = 10: sort the rows"),
        ({"rows": [ROWS[0] | {"at": math.nan}]}, "rows.0.at: Input should be a finite number"),
        ({"rows": [ROWS[0] | {"deviation": math.nan}]}, "rows.0.deviation"),
        ({"rows": [ROWS[0] | {"U": 0.0}]}, "rows.0.U: Input should be greater than 0"),
        ({"rows": [ROWS[0] | {"at": -5.0}]}, "rates are stated without a sign"),
        ({"rows": [{"deviation": 0.0, "U": 1e-5}]}, "a row needs `at`, the rate"),
        ({"rows": [ROWS[0] | {"axis": "inner"}, ROWS[1]]}, "name one in each, or none"),
        ({"polynomials": [POLYNOMIAL, POLYNOMIAL]}, "two polynomials of axis (every)"),
        ({"polynomials": [POLYNOMIAL | {"highest": 1.0}]}, "lowest = 1 is not below highest = 1"),
        ({"polynomials": [POLYNOMIAL | {"coefficients": [0, 1]}]}, "reaches 2 between 1 and 2"),
        ({"rows": ROWS, "drift": DRIFT}, "functions.rate.drift counts from calibrated_on"),
        ({"rows": ROWS, "standard": {"limits": {"rate": {"half_width": 1e-5,
          "distribution": "normal"}}}}, "rate stands in limits and in functions"),
    ],
)  # fmt: skip
def test_what_is_no_function_of_the_rate_is_refused(function, sentence):
    assert sentence in fault("rate", **function)


def test_what_has_no_function_is_refused():
    assert "state fixture in limits" in fault("fixture", rows=ROWS)
    assert "functions.gravity has one value" in fault("gravity", rows=ROWS)
    assert "functions.time_base has one value" in fault("time_base", polynomials=[POLYNOMIAL])


# Limits as they are written in a file: relative ones, rules of their own, what is refused.

LIMIT = {"item": "gyro_bias", "unit": "deg/s"}


def tolerance(limit: dict[str, Any], **file: Any) -> Tolerance:
    return Tolerance.model_validate(
        {"manufacturer": "m", "model": "m", "document": "d", "limits": [LIMIT | limit]} | file
    )


@pytest.mark.parametrize(
    ("written", "absolute"),
    [
        ({"nominal": 1.0, "magnitude": 0.01}, (0.99, 1.01)),
        ({"nominal": 3.2, "magnitude": 0.05}, (3.04, 3.36)),
        ({"nominal": -2.0, "lower": -0.1, "upper": 0.05}, (-2.2, -1.9)),
        ({"nominal": 200.0, "upper": 0.05}, (None, 210.0)),
        ({"nominal": 200.0, "lower": -0.05}, (190.0, None)),
    ],
)
def test_relative_limits_count_from_their_nominal(written, absolute):
    assert Limit(**LIMIT, relative=True, **written).bounds == absolute


@pytest.mark.parametrize(
    ("limit", "file", "names"),
    [
        ({"magnitude": 0.1, "relative": True}, {}, "nominal other than 0"),
        ({"magnitude": 0.1, "relative": True, "nominal": 0}, {}, "nominal other than 0"),
        ({"magnitude": 0.1, "nominal": 1}, {}, "not relative"),
        ({"magnitude": 1}, {"guard_band_factor": 1}, "no limit has the rule guard_band"),
        ({"magnitude": 1, "guard_band_factor": 1}, {}, "rule simple_acceptance"),
        ({"magnitude": 1}, {"rule": "shared_risk"}, "no bound on U is agreed"),
        ({"upper": 1}, {"rule": "shared_risk", "min_capability": 3}, "no bound on U is agreed"),
        ({"magnitude": 1, "U_max": 0}, {}, "U_max"),
        ({"magnitude": 1}, {"rule": "guard_band", "guard_band_factor": -1.01}, "guard_band_factor"),
        ({"magnitude": 1, "rule": "guard_band", "guard_band_factor": -1.2}, {}, "equal to -1"),
        ({"magnitude": 1, "prior": {"mean": 0, "sd": 0}}, {}, "sd"),
        ({"magnitude": 1, "rule": "guess"}, {}, "guess"),
    ],
)
def test_a_rule_that_is_not_complete_is_refused(limit, file, names):
    with pytest.raises(ValidationError, match=names):
        tolerance(limit, **file)


@pytest.mark.parametrize("written", [True, "1"])
@pytest.mark.parametrize("field", ["magnitude", "lower", "U_max"])
def test_a_limit_is_a_number_and_nothing_that_looks_like_one(field, written):
    with pytest.raises(ValidationError, match=field):
        tolerance({"upper": 3.0, field: written} if field != "magnitude" else {field: written})


@pytest.mark.parametrize("half_width", [True, "0.001", 1.5, 0.0, float("inf")])
def test_a_laboratory_limit_is_a_number_that_equipment_can_have(half_width):
    limit = {"half_width": half_width, "distribution": "normal", "source": "paper"}
    with pytest.raises(ValidationError, match="half_width"):
        EquipmentLimit.model_validate(limit)
    assert EquipmentLimit.model_validate(limit | {"half_width": 1}).half_width == 1.0


# Orders: the same model from the command line, from JSON and from a schedule.


def test_terms_as_text_are_names_each_once():
    order = CalibrateOrder.model_validate(
        {"run": "r1", "terms": " lever_arm,earth_rotation,lever_arm"}
    )
    assert order.terms == ("earth_rotation", "lever_arm")
    assert CalibrateOrder(run="r1", terms=" , ").terms == ()
    assert CalibrateOrder(run="r1").terms is None


def test_an_empty_reason_is_refused_by_the_name_of_its_option():
    with pytest.raises(Unusable, match=r"^--why is empty: give a text\.$"):
        order_of(WithdrawOrder, certificate="C-1", by="Ann", why="")


def test_order_survives_json():
    order = CertifyOrder(run="r1", method="jjf2003", calibrated_on=date(2026, 1, 2), budget=True)
    assert CertifyOrder.model_validate_json(order.model_dump_json()) == order


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"method": "guess"}, r"--method guess: choose one of jjf2003, joint, jjf1536"),
        ({"uncertainty": "guess"}, r"--uncertainty guess: choose one of gum, montecarlo, example"),
        ({"terms": "a", "method": "joint"}, r"leave --method joint or --terms out"),
        ({"terms": "a", "uncertainty": "example"}, r"leave --uncertainty example out"),
    ],
)
def test_what_cannot_be_ordered_is_one_sentence(fields, says):
    with pytest.raises(Unusable, match=says) as refusal:
        order_of(CalibrateOrder, run="r1", **fields)
    assert "\n" not in str(refusal.value)


def test_production_hands_down_all_that_its_certificate_needs():
    order = ProduceOrder(
        station="station.json", home="h", tolerance="t", laboratory="l", client_order="o",
        calibrated_on=date(2026, 1, 2), budget=True,
    )  # fmt: skip
    certify = order.certify("r1")
    assert certify == CertifyOrder(
        run="r1", home="h", tolerance="t", laboratory="l", client_order="o",
        calibrated_on=date(2026, 1, 2), budget=True,
    )  # fmt: skip


# Passwords in URLs: whole where they are used, and nowhere where a URL is shown.

PLACES = [
    "mailto://lab:{}@mail.example.org:587?from=lab@example.org&to=c@example.org",
    "postgresql://lab:{}@db.example.org:5432/mimucal",
    "http://lab:{}@prefect.example.org:4200/api",
    "s3://lab:{}@bucket.example/prefix?endpoint=store.example.org:9000&scheme=http",
]
WRITTEN = ["p@ss", "a/b", "c#d", "e?f", "g%h", "i:j", "k?l=m@n", "@", "///", "x@y/z#?%:q", "[::1]"]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("password", WRITTEN)
def test_a_password_as_it_is_stays_whole_and_leaves_the_host_alone(place, password):
    url = place.format(password)
    parts = urlsplit(escaped(url))
    assert unquote(parts.password) == password
    assert parts.hostname == urlsplit(place.format("p")).hostname
    assert login_apart(url)[1:] == ("lab", password)
    assert shown(url) == place.format("***")
    assert has_secret(url)


@given(st.text(min_size=1), st.sampled_from(PLACES))
def test_a_variable_is_taken_literally(password, place):
    url = filled(place.format("${SECRET}"), {"SECRET": password, "HOST": "h"})
    parts = urlsplit(url)
    assert unquote(parts.password or "") == password
    assert parts.hostname == urlsplit(place.format("p")).hostname


@pytest.mark.parametrize(
    "url",
    [
        "mailto://127.0.0.1:25?from=lab@example.org&to=client@example.org",
        "postgresql:///name?host=/run/postgresql",
        "postgresql://user@host/name",
        "sqlite:////home/x/catalog.sqlite",
        "s3://bucket/prefix?endpoint=store.example.org:9000",
        "slack://T1JJ3T3L2/A1BRTD4JD/TIiajkdnlazkcOXrIdevi7FQ",
        "mailto://h.example.org/client@example.org",
        "mailto://h.example.org:25/client@example.org/other@example.org?from=lab@example.org",
    ],
)
def test_a_url_without_a_password_is_as_it_was(url):
    assert escaped(url) == shown(url) == url
    assert not has_secret(url)


def test_a_password_in_the_query_is_not_shown():
    assert shown("postgresql://h/n?password=p@ss&a=b") == "postgresql://h/n?password=***&a=b"


@pytest.mark.parametrize("password", WRITTEN)
def test_the_database_gets_it_and_its_name_does_not_hold_it(monkeypatch, tmp_path, password):
    monkeypatch.setenv("MIMUCAL_DATABASE", PLACES[1].format(password))
    home = Home(tmp_path)
    assert (url_of(home).password, url_of(home).host) == (password, "db.example.org")
    assert name_of(home) == "postgresql+psycopg://lab:***@db.example.org:5432/mimucal"
    monkeypatch.setenv("MIMUCAL_DATABASE", f"mysql://lab:{password}@db.example.org/mimucal")
    with pytest.raises(Unusable, match=r"mysql://lab:\*\*\*@db.example.org/mimucal, which"):
        url_of(home)
