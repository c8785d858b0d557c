"""Orders as the parameters of a flow run that somebody who reaches Prefect's server could give."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from flows.orders import signed_orders
from schemas.certificate_orders import (
    AmendOrder,
    CertifyOrder,
    CheckOrder,
    IssueOrder,
    ProduceOrder,
    StepOrder,
    WithdrawOrder,
)
from schemas.orders import OrderModel
from storage.order_key import signed
from tests.proof.hostile.attacked import Attacked

Parameters = dict[str, Any]


@dataclass(frozen=True)
class Forged:
    """kind: what it tries. flow: which is ordered. parameters: of the order, as JSON values."""

    kind: str
    flow: str
    parameters: Parameters


def orders_of(there: Attacked, by: dict[str, str]) -> dict[str, OrderModel]:
    """An order of each flow that acts in a person's name, which would act."""
    draft, checked, issued = (there.certificates[s] for s in ("draft", "checked", "issued"))
    return {
        "withdraw": WithdrawOrder(certificate=issued, by=by["withdraw"], why="hostile"),
        "check": CheckOrder(certificate=draft, by=by["check"]),
        "issue": IssueOrder(certificate=checked, by=by["issue"]),
        "amend": AmendOrder(certificate=issued, by=by["amend"], why="hostile"),
        "certify": CertifyOrder(run="r1", by=by["certify"]),
        "produce": ProduceOrder(station="T1", by=by["produce"]),
    }


RIGHTLY = {
    "withdraw": "issuer", "check": "verifier", "issue": "issuer", "amend": "operator",
    "certify": "operator", "produce": "operator",
}  # fmt: skip


def forged(there: Attacked) -> Iterator[Forged]:
    """Every forged order; that of a used signature stands apart, for something must use it first.

    Run it with the home of MIMUCAL_HOME attacked: signatures are made by its key.
    """
    ghosts = orders_of(there, dict.fromkeys(RIGHTLY, "Ghost"))
    right = orders_of(there, RIGHTLY)
    for flow, order in ghosts.items():
        yield _as("a name alone", flow, order)
        yield _as("signed for nobody's user", flow, signed_orders.sign(flow, order))
    for flow, order in right.items():
        yield _as("a user's name alone", flow, order)
        unsigned = signed_orders.sign(flow, order)
        yield _changed("forged signature", flow, unsigned, mac="0" * 64)
        yield _changed("other person's signature", flow, unsigned, person="administrator")
    wrong = dict.fromkeys(RIGHTLY, "viewer")
    for flow, order in orders_of(there, wrong).items():
        yield _as("signed for another role", flow, signed_orders.sign(flow, order))
    yield from _other_content(there, right)
    for flow, order in right.items():
        yield _as("expired", flow, _signed_at(there, flow, order, -timedelta(days=8)))
        yield _as("signed in the future", flow, _signed_at(there, flow, order, timedelta(days=1)))


def _other_content(there: Attacked, right: dict[str, OrderModel]) -> Iterator[Forged]:
    """Valid signatures, of another order and of another flow."""
    issued = there.certificates["issued"]
    for flow in ("check", "issue"):
        signed_ = signed_orders.sign(flow, right[flow])
        yield _as("changed content", flow, signed_.model_copy(update={"certificate": issued}))
    withdraw = signed_orders.sign("withdraw", right["withdraw"])
    yield _as("changed content", "withdraw", withdraw.model_copy(update={"why": "other"}))
    for signed_for, flow in (("check", "issue"), ("issue", "check"), ("withdraw", "amend")):
        other = right[signed_for].model_copy(update={"by": "administrator"})
        signature = getattr(signed_orders.sign(signed_for, other), "signature", None)
        order = right[flow].model_copy(update={"by": "administrator", "signature": signature})
        yield _as("signature of another flow", flow, order)


def replay(there: Attacked) -> tuple[Forged, Callable[[], None]]:
    """A withdrawal whose signature is used by the call that comes with it, for nothing."""
    order = signed_orders.sign("withdraw", orders_of(there, RIGHTLY)["withdraw"])

    def use() -> None:
        with signed_orders.accepted("withdraw", order):
            pass

    return _as("replayed", "withdraw", order), use


def _signed_at(there: Attacked, flow: str, order: OrderModel, when: timedelta) -> OrderModel:
    assert isinstance(order, StepOrder | CertifyOrder | ProduceOrder)
    unsigned = {
        "person": order.by, "signed_at": datetime.now(UTC) + when, "nonce": "1" * 32,
        "signed_on": "attacker@elsewhere",
    }  # fmt: skip
    content = order.model_dump(mode="json", exclude={"signature"})
    return order.model_copy(update={"signature": signed(flow, content, unsigned, there.home)})


def _changed(kind: str, flow: str, order: OrderModel, **changes: Any) -> Forged:
    signature = getattr(order, "signature", None)
    assert signature is not None
    changed = signature.model_copy(update=changes)
    return _as(kind, flow, order.model_copy(update={"signature": changed}))


def _as(kind: str, flow: str, order: OrderModel) -> Forged:
    """mac included, which no representation shows, but an attacker who listens has."""
    return Forged(kind, flow, order.model_dump(mode="json"))
