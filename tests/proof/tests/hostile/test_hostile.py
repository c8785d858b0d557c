"""Hostile calls of the pages and of the flows: none acts, and each is logged."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from schemas.base import Unusable
from storage.catalogue import trail
from storage.catalogue.certificates import register
from storage.home import Home
from tests.pages_server import served
from tests.proof.hostile.attacked import Attacked, attacked, log_lines
from tests.proof.hostile.browser import Browser
from tests.proof.hostile.forged_orders import RIGHTLY, forged, orders_of, replay
from tests.proof.hostile.page_calls import all_calls, is_refused, logins, orders_on
from tests.proof.hostile.run import MOST, run_on_line

pytestmark = pytest.mark.usefixtures("unprinted")


@pytest.fixture
def there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Attacked:
    for name in ("MIMUCAL_DATABASE", "PREFECT_API_URL"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("MIMUCAL_HOME", str(tmp_path / "home"))
    return attacked(Home(tmp_path / "home"))


@pytest.fixture
def address(there: Attacked) -> Iterator[str]:
    with served(there.home) as address:
        yield address


def test_no_hostile_call_of_the_pages_acts_and_each_is_logged(
    there: Attacked, address: str, tmp_path: Path
) -> None:
    (tmp_path / "bare").mkdir()
    faults = []
    with log_lines() as lines, served(Home(tmp_path / "bare")) as bare:
        for call in all_calls(there, address, bare):
            logged = len(lines)
            answer = call.send()
            if not is_refused(answer) or len(lines) == logged:
                faults.append((call, answer.status, lines[logged:]))
        led = {call.what: call.send().location for call in logins(address)}
    assert faults == []
    assert set(led.values()) == {"/"}
    assert there.acted() == []


def test_the_same_order_acts_for_whom_it_is_meant(there: Attacked, address: str) -> None:
    issuer = Browser(address)
    issuer.log_in("issuer")
    issuer.order("withdraw", orders_on(there)["withdraw"], issuer.token())
    states = {entry.number: entry.state for entry in register(there.home)}
    assert states[there.certificates["issued"]] == "withdrawn"
    assert {entry.person for entry in trail.entries(there.home)[-3:]} == {"issuer"}


def test_no_forged_order_acts_in_a_flow_and_each_is_in_the_trail(there: Attacked) -> None:
    from flows.on_prefect import prefect_flows

    calls = list(forged(there))
    with log_lines() as lines:
        for call in calls:
            flow = getattr(prefect_flows, call.flow)
            (parameter,) = flow.validate_parameters({"order": call.parameters}).values()
            logged = len(lines)
            with pytest.raises(Unusable):
                flow.fn(parameter)
            assert len(lines) > logged, call
    assert there.acted() == []
    refused = Counter(entry.action for entry in trail.entries(there.home)[there.entries :])
    assert refused == Counter(f"refuse {call.flow}" for call in calls)


def test_a_used_signature_is_refused_and_a_fresh_one_acts(there: Attacked) -> None:
    from flows.on_prefect import prefect_flows
    from flows.orders import signed_orders

    again, use = replay(there)
    use()
    there.look()
    flow = prefect_flows.withdraw
    (order,) = flow.validate_parameters({"order": again.parameters}).values()
    with pytest.raises(Unusable, match="used already"):
        flow.fn(order)
    assert there.acted() == []
    flow.fn(signed_orders.sign("withdraw", orders_of(there, RIGHTLY)["withdraw"]))
    assert len(there.acted()) > 0


@pytest.mark.rehearsal
def test_no_hostile_call_of_a_line_acts(tmp_path: Path) -> None:
    done = run_on_line(tmp_path, MOST)
    assert done.faults == ()
    assert done.calls > 200
