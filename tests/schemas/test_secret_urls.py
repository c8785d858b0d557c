"""Passwords in URLs: whole where they are used, and nowhere where a URL is shown."""

from urllib.parse import unquote, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.base import Unusable, escaped, filled, has_secret, login_apart, shown
from storage.catalogue.database import name_of, url_of
from storage.home import Home

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
