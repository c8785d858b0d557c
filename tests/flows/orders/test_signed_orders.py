"""A name in an order counts only with a signature, whoever gives the order."""

import logging
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from flows import execute
from flows.carry_out import carry_out
from flows.orders import signed_orders
from flows.orders.signed_orders import accepted, carry_out_signed, sign
from schemas.base import Unusable
from schemas.orders import AcquireOrder, CertifyOrder, CheckOrder, ProduceOrder, StepOrder
from storage.catalogue import audit_trail, users
from storage.catalogue.certificates import register
from storage.catalogue.database import Busy
from storage.home import Home
from tests.drafts import draft

pytestmark = pytest.mark.usefixtures("unprinted")


@pytest.fixture
def place(home: Path) -> Home:
    return Home(home)


@pytest.fixture
def order(place: Home) -> CheckOrder:
    return CheckOrder(certificate=draft(place).certificate.number, by="Zhao")


def taken(flow: str, order: StepOrder) -> None:
    with accepted(flow, order):
        pass


def state(place: Home) -> set[str]:
    return {entry.state for entry in register(place)}


def test_a_signed_order_is_carried_out_once_and_the_trail_says_who_signed_where(
    place: Home, order: CheckOrder
) -> None:
    signed = sign("check", order)
    taken("check", signed)
    with pytest.raises(Unusable, match="used already"):
        taken("check", signed)
    entries = {entry.action: entry for entry in audit_trail.entries(place)}
    assert (entries["sign check"].person, entries["sign check"].subject) == (
        "Zhao", order.certificate,
    )  # fmt: skip
    assert '"signed_on":"' in entries["sign check"].details
    assert entries["refuse check"].person == "unknown"
    assert '"claimed":"Zhao"' in entries["refuse check"].details


def test_a_name_alone_gives_no_order(
    place: Home, order: CheckOrder, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, "mimucal.access"), pytest.raises(Unusable, match="alone"):
        taken("check", order.model_copy(update={"by": "Ghost"}))
    assert "Ghost" in caplog.text
    assert not (place.path / "orders.key").exists()
    assert audit_trail.entries(place)[-1].action == "refuse check"


@pytest.mark.parametrize(
    "changed",
    [{"certificate": "A-2"}, {"by": "Ghost"}, {"reason": "other"}, {"home": "/elsewhere"}],
)
def test_a_signature_is_of_the_content_that_was_signed(
    order: CheckOrder, changed: dict[str, Any]
) -> None:
    signed = sign("check", order)
    with pytest.raises(Unusable, match=r"not that of this order|cannot be read"):
        taken("check", signed.model_copy(update=changed))


@pytest.mark.parametrize(
    "changed",
    [
        {"person": "Ghost"}, {"signed_at": datetime.now(UTC) + timedelta(seconds=9)},
        {"nonce": "0" * 32}, {"signed_on": "root@elsewhere"}, {"mac": "0" * 64},
    ],
)  # fmt: skip
def test_a_signature_that_was_changed_is_none(order: CheckOrder, changed: dict[str, Any]) -> None:
    signed = sign("check", order)
    assert signed.signature is not None
    forged = signed.signature.model_copy(update=changed)
    with pytest.raises(Unusable, match="not that of this order"):
        taken("check", signed.model_copy(update={"signature": forged}))


def test_a_signature_is_for_one_flow(order: CheckOrder) -> None:
    with pytest.raises(Unusable, match="not that of this order, flow"):
        taken("issue", sign("check", order))


def test_a_signature_of_another_home_counts_nothing(order: CheckOrder, tmp_path: Path) -> None:
    other = order.model_copy(update={"home": str(tmp_path / "other")})
    signed = sign("check", other).signature
    sign("check", order)  # this home has a key of its own
    with pytest.raises(Unusable, match="not that of this order"):
        taken("check", order.model_copy(update={"signature": signed}))


@pytest.mark.parametrize("days", [-1, 8])
def test_a_signature_is_good_for_a_week(
    order: CheckOrder, days: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Then(datetime):
        @classmethod
        def now(cls, tz: Any = None) -> datetime:  # type: ignore[override]
            return datetime.now(tz) - timedelta(days=days)

    with monkeypatch.context() as before:
        before.setattr(signed_orders, "datetime", Then)
        signed = sign("check", order)
    with pytest.raises(Unusable, match="7 days ago or still to come"):
        taken("check", signed)


def test_a_person_needs_the_role_where_the_home_has_users(place: Home, order: CheckOrder) -> None:
    users.add("Li", "operator", "hash", place, "Admin")
    with pytest.raises(Unusable, match="no user of this home"):
        taken("check", sign("check", order))
    with pytest.raises(Unusable, match="no user of this home"):
        taken("check", sign("check", order.model_copy(update={"by": "Li"})))
    users.add("Zhao", "verifier", "hash", place, "Admin")
    taken("check", sign("check", order))


def test_an_order_that_names_nobody_needs_no_signature(place: Home) -> None:
    for flow, order in (
        ("certify", CertifyOrder(run="r1")),
        ("produce", ProduceOrder(station="T1")),
        ("acquire", AcquireOrder(station="T1")),
    ):
        assert sign(flow, order) == order
        with accepted(flow, order):
            pass
    assert not place.path.exists()


def test_who_measures_is_believed_by_a_signature_alone(place: Home) -> None:
    order = AcquireOrder(station="T1", home=str(place.path), by="Li")
    with pytest.raises(Unusable, match="a name alone"), accepted("acquire", order):
        pass
    with accepted("acquire", sign("acquire", order)):
        pass


def test_a_production_signed_for_a_drafter_leaves_no_signature_to_its_certificates(
    place: Home,
) -> None:
    signed = sign("produce", ProduceOrder(station="T1", by="Li"))
    assert signed.signature is not None
    assert signed.certify("r1").signature is None


def test_a_flow_run_that_crashed_goes_on_with_its_order_and_no_other_does(
    order: CheckOrder, monkeypatch: pytest.MonkeyPatch
) -> None:
    signed = sign("check", order)
    monkeypatch.setattr(signed_orders, "flow_run", lambda: "first")
    for crash in (Busy, RuntimeError):
        with pytest.raises(crash), accepted("check", signed):
            raise crash
    monkeypatch.setattr(signed_orders, "flow_run", lambda: "second")
    with pytest.raises(Unusable, match="used already"):
        taken("check", signed)
    monkeypatch.setattr(signed_orders, "flow_run", lambda: "first")
    taken("check", signed)
    with pytest.raises(Unusable, match="used already"):
        taken("check", signed)


def test_an_order_that_the_rules_refuse_is_not_kept_for_a_better_moment(
    order: CheckOrder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(signed_orders, "flow_run", lambda: "first")
    signed = sign("check", order.model_copy(update={"by": "Wang"}))  # who drafted it
    with pytest.raises(Unusable, match="another person"), accepted("check", signed):
        raise Unusable("another person must check it")
    with pytest.raises(Unusable, match="used already"):
        taken("check", signed)


def test_pages_carry_out_what_they_signed_and_a_desk_needs_no_signature(
    place: Home, order: CheckOrder
) -> None:
    assert carry_out_signed(execute.check, order).state == "checked"
    other = CheckOrder(certificate=draft(place, "2").certificate.number, by="Zhao")
    assert carry_out(execute.check, other, other.certificate).state == "checked"
    assert state(place) == {"checked"}


def test_a_refusal_makes_no_home_and_writes_into_none_that_is_no_home(
    home: Path, tmp_path: Path
) -> None:
    there = tmp_path / "anywhere"
    there.mkdir()
    with pytest.raises(Unusable, match="alone"):
        taken("check", CheckOrder(certificate="A-1", by="Ghost", home=str(there)))
    assert not list(there.iterdir())
    assert not home.exists()


def test_what_a_stranger_sent_is_printable_in_the_trail(place: Home, order: CheckOrder) -> None:
    sent = order.model_copy(update={"by": "G\x00\ud800\n" + "h" * 500})
    with pytest.raises(Unusable, match=r"G\?\?\?hhh"):
        taken("check", sent)
    assert len(audit_trail.entries(place)[-1].details) < 800
