"""Who is let in, and what is refused."""

import logging
from collections.abc import Callable

import httpx
import pytest
from flask.testing import FlaskClient

from flows.pages import login
from flows.pages.app import make_app, serve
from flows.pages.login import session_cookie
from schemas.access import MAY, ROLES, User, Visitor
from schemas.base import Unusable
from storage import whole_files
from storage.catalogue import audit_trail, users
from storage.catalogue.database import Busy
from storage.home import Home
from tests.pages_server import served

PASSWORD = "correct horse battery"
PAGE = {"Accept": "text/html"}


@pytest.fixture
def home(tmp_path) -> Home:
    users.add("Wang Li", "operator", login.hashed(PASSWORD), Home(tmp_path), "Admin")
    return Home(tmp_path)


@pytest.fixture
def client(home) -> FlaskClient:
    return make_app(home).server.test_client()


def token(client: FlaskClient) -> str:
    page = client.get("/login", headers=PAGE).text
    return page.partition('name="csrf_token" value="')[2].partition('"')[0]


def log_in(client: FlaskClient, password: str = PASSWORD, name: str = "Wang Li") -> int:
    form = {"name": name, "password": password, "next": "/runs", "csrf_token": token(client)}
    return client.post("/login", data=form).status_code


def test_a_home_without_users_is_looked_at_by_everybody_who_may_do_nothing(tmp_path):
    assert make_app(Home(tmp_path)).server.test_client().get("/api/v1/runs").status_code == 200
    assert not any(Visitor(role=role).may(action) for role in ROLES for action in MAY)


def test_nobody_sees_anything_without_a_name(client):
    assert client.get("/runs", headers=PAGE).headers["Location"] == "/login?next=/runs"
    for path in ("/api/v1/runs", "/api/v1/openapi.json", "/_dash-layout", "/_dash-dependencies"):
        assert client.get(path).status_code == 401, path
    assert client.get("/certificate/A-1.pdf").status_code in (302, 401)
    assert client.post("/_dash-update-component", json={}).status_code in (400, 401)


def test_a_session_begins_with_the_password_and_ends_with_the_user(client, home):
    assert log_in(client, "wrong") == 403
    assert log_in(client) == 302
    assert client.get("/api/v1/runs").status_code == 200
    assert "Wang Li" in client.get("/_dash-layout").text
    cookie = client.get_cookie(session_cookie(home))
    assert cookie is not None
    assert (cookie.http_only, cookie.same_site) == (True, "Lax")
    users.add("Wang Li", "operator", login.hashed("another password"), home, "Admin")
    assert client.get("/api/v1/runs").status_code == 401


def test_a_session_of_a_user_who_was_removed_is_none(client, home):
    log_in(client)
    users.remove("Wang Li", home, "Admin")
    users.add("Zhao Min", "viewer", login.hashed(PASSWORD), home, "Admin")
    assert client.get("/api/v1/runs").status_code == 401
    actions = [(entry.person, entry.action, entry.subject) for entry in audit_trail.entries(home)]
    assert ("Admin", "remove user", "Wang Li") in actions
    hashes = [user.password for user in users.users(home).values()]
    assert not any(one in entry.details for entry in audit_trail.entries(home) for one in hashes)


def test_a_session_outlives_the_process_that_serves(client, home):
    log_in(client)
    kept = client.get_cookie(session_cookie(home))
    assert kept is not None
    again = make_app(home).server.test_client()
    again.set_cookie(session_cookie(home), kept.value)
    assert again.get("/api/v1/runs").status_code == 200
    assert (home.path / "pages.key").stat().st_mode & 0o077 == 0


def test_two_homes_on_one_host_keep_their_sessions_apart(client, home, tmp_path):
    log_in(client)
    assert client.get_cookie(session_cookie(home)) is not None
    assert client.get_cookie(session_cookie(Home(tmp_path / "other"))) is None


def test_a_form_without_its_token_is_refused(client):
    form = {"name": "Wang Li", "password": PASSWORD}
    assert client.post("/login", data=form).status_code == 400
    log_in(client)
    assert client.post("/logout").status_code == 400
    assert client.post("/_dash-update-component", json={}).status_code == 400


def test_a_session_that_was_left_is_over_for_every_copy_of_its_cookie(client, home):
    log_in(client)
    kept = client.get_cookie(session_cookie(home))
    assert kept is not None
    assert client.post("/logout", data={"csrf_token": token(client)}).status_code == 302
    for server in (client, make_app(home).server.test_client()):
        server.set_cookie(session_cookie(home), kept.value)
        assert server.get("/api/v1/runs").status_code == 401
    actions = [(entry.person, entry.action) for entry in audit_trail.entries(home)]
    assert actions[-2:] == [("Wang Li", "log in"), ("Wang Li", "log out")]


def test_a_login_leads_to_a_page_of_ours_and_nowhere_else(client):
    for wanted, leads in (
        ("/runs", "/runs"), ("//line", "/"), ("///line", "/"), ("line", "/"), ("/\\line", "/"),
        ("https://elsewhere.example/line", "/"), ("/line?next=//line", "/"), ("/line\r\nX: y", "/"),
    ):  # fmt: skip
        form = {"name": "Wang Li", "password": PASSWORD, "next": wanted}
        entered = client.post("/login", data=form | {"csrf_token": token(client)})
        assert entered.headers["Location"] == leads, wanted


def test_tries_that_fail_shut_the_gate_for_the_name_at_the_address_alone(client, home):
    users.add("Zhao Min", "viewer", login.hashed(PASSWORD), home, "Admin")
    codes = [log_in(client, "wrong") for _ in range(6)]
    assert codes == [403] * 5 + [429]
    assert log_in(client) == 429
    assert client.get("/api/v1/runs", auth=("Wang Li", PASSWORD)).status_code == 401
    assert log_in(client, name="Zhao Min") == 302
    client.environ_base["REMOTE_ADDR"] = "10.0.0.9"
    assert log_in(client) == 302
    refusals = [entry for entry in audit_trail.entries(home) if entry.action.startswith("refuse")]
    assert [entry.action for entry in refusals] == [
        *["refuse log in"] * 5, "refuse further tries to log in"
    ]  # fmt: skip
    assert {(entry.person, entry.subject) for entry in refusals} == {("unknown", "Wang Li")}
    assert '"address":"127.0.0.1"' in refusals[0].details


def test_a_name_that_nobody_has_is_shut_like_any_other_and_not_kept(client, home):
    assert [log_in(client, "wrong", "hunter2 (a password)") for _ in range(6)] == [403] * 5 + [429]
    assert not any("hunter2" in entry.model_dump_json() for entry in audit_trail.entries(home))


def test_many_addresses_do_not_try_one_account_forever_nor_one_address_all_accounts(monkeypatch):
    monkeypatch.setattr(login, "DUMMY_HASH", "none")  # takes no time, on purpose
    gate = login.LoginLimiter()
    user = User(name="W", role="viewer", password="none", added_at="2026-11-27T00:00:00Z")
    for number in range(20):
        gate.check(user, "wrong", "W", f"10.0.0.{number}")
    assert gate.is_locked("W", "10.0.1.1")
    for number in range(60):
        gate.check(None, "wrong", f"name {number}", "10.0.2.2")
    assert gate.is_locked("anybody", "10.0.2.2")
    assert not gate.is_locked("anybody", "10.0.2.3")


def test_every_request_that_is_refused_is_a_line_of_the_log(client, caplog):
    with caplog.at_level(logging.INFO, "mimucal.access"):
        client.get("/api/v1/runs")
        client.get("/line", headers=PAGE)
        client.post("/login", data={})
        client.put("/api/v1/runs")
    lines = [each.getMessage() for each in caplog.records]
    assert [line.split()[0] for line in lines] == ["401", "302", "400", "401"]
    assert all("127.0.0.1" in line for line in lines)


def test_a_script_says_its_name_with_each_request(client):
    assert client.get("/api/v1/runs", auth=("Wang Li", PASSWORD)).status_code == 200
    refused = client.get("/api/v1/runs", auth=("Nobody", PASSWORD))
    assert refused.status_code == 401
    assert refused.headers["WWW-Authenticate"].startswith("Basic")


def behind_proxy(home: Home, settings: str) -> Callable[..., int]:
    """What a request with the proxy's header is answered, from an address and with more headers."""
    (home.path / "pages.toml").write_text(f"[proxy]\n{settings}", encoding="utf-8")
    client = make_app(home).server.test_client()

    def asked(address: str, name: str, **more: str) -> int:
        headers = {"X-Remote-User": name} | {k.replace("_", "-"): v for k, v in more.items()}
        return client.get(
            "/api/v1/runs", headers=headers, environ_base={"REMOTE_ADDR": address}
        ).status_code

    return asked


def test_the_header_of_a_proxy_is_believed_from_its_address_alone(home):
    asked = behind_proxy(home, 'addresses = ["10.0.0.7"]\nheader = "X-Remote-User"\n')
    assert asked("10.0.0.7", "Wang Li") == 200
    assert asked("10.0.0.7", "Nobody") == 401
    assert asked("127.0.0.1", "Wang Li") == 401


def test_a_proxy_on_this_machine_is_known_by_its_secret(home):
    secret = whole_files.made(home.path / "proxy.secret")
    asked = behind_proxy(
        home,
        'addresses = ["127.0.0.1"]\nheader = "X-Remote-User"\nsecret_file = "proxy.secret"\n',
    )
    assert asked("127.0.0.1", "Wang Li", X_Proxy_Secret=secret) == 200
    assert asked("127.0.0.1", "Nobody", X_Proxy_Secret=secret) == 401
    assert asked("10.0.0.7", "Wang Li", X_Proxy_Secret=secret) == 401
    for wrong in ("", "0" * 64, secret[:-1], "é"):
        assert asked("127.0.0.1", "Wang Li", X_Proxy_Secret=wrong) == 401


@pytest.mark.parametrize("address", ["127.0.0.1", "127.0.0.2", "::1", "::ffff:127.0.0.1"])
def test_a_proxy_on_this_machine_without_a_secret_is_refused(home, address):
    text = f'[proxy]\naddresses = ["{address}"]\nheader = "X-Remote-User"\n'
    (home.path / "pages.toml").write_text(text, encoding="utf-8")
    with pytest.raises(Unusable, match=r'add secret_file = "proxy.secret"'):
        make_app(home)


def test_a_proxys_secret_that_others_may_read_is_refused(home):
    whole_files.made(home.path / "proxy.secret")
    (home.path / "proxy.secret").chmod(0o644)
    with pytest.raises(Unusable, match="can be read by others"):
        behind_proxy(
            home, 'addresses = ["::1"]\nheader = "X-Remote-User"\nsecret_file = "proxy.secret"\n'
        )


def test_pages_without_users_are_served_on_this_machine_alone(tmp_path):
    with pytest.raises(Unusable, match="mimucal user add"):
        serve(Home(tmp_path), "0.0.0.0", 0)


def test_pages_of_this_machine_are_not_read_under_another_hosts_name(tmp_path):
    with served(Home(tmp_path)) as address:
        asked = f"{address}/api/v1/runs"
        assert httpx.get(asked).status_code == 200
        assert httpx.get(asked, headers={"Host": "elsewhere.example"}).status_code == 400


def test_a_password_is_kept_as_an_argon2_hash(home):
    (user,) = users.users(home).values()
    assert user.password.startswith("$argon2id$")
    assert PASSWORD not in repr(user)


def test_without_its_database_the_frame_is_there_and_the_json_says_why(client, monkeypatch):
    def stopped(_: Home) -> dict[str, users.User]:
        raise Busy("The catalogue cannot be used.")

    monkeypatch.setattr("flows.pages.login.registered_users", stopped)
    assert client.get("/runs", headers=PAGE).status_code == 200
    refused = client.get("/api/v1/runs")
    assert (refused.status_code, refused.json) == (503, {"error": "The catalogue cannot be used."})
    monkeypatch.undo()
    assert client.get("/api/v1/runs").status_code == 401
