"""Orders in a person's name: signed by the page or the command line, checked by the flow.

A flow takes whatever its parameters say, and whoever reaches Prefect's server may order it. So a
name there counts only with a signature by the key of the home (ORDER_KEY), which is made
for a person who is logged in, or by an account of this system that may read the key.
"""

import hashlib
import hmac
import json
import secrets
import socket
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from typing import Any, TypeVar

from flows import execute
from flows.access_log import plain, refused
from schemas.access import Action, Visitor
from schemas.base import Unusable
from schemas.certificate import Signature
from schemas.orders import OrderModel
from storage import whole_files
from storage.catalogue import certificates
from storage.catalogue.database import Busy
from storage.catalogue.users import users
from storage.home import Home, home
from tasks.stages.stop import login

AGE = timedelta(days=7)  # a station may be down over a long weekend
AHEAD = timedelta(minutes=5)  # largest difference between the clocks of two computers
FLOWS: Mapping[str, Action] = {  # that act in a person's name, and what the role must allow
    "acquire": "acquire", "produce": "acquire", "certify": "certify", "amend": "certify",
    "check": "check", "issue": "issue", "withdraw": "withdraw",
}  # fmt: skip
SUBJECTS = ("certificate", "run", "station")  # the field that says what an order is about

Order = TypeVar("Order", bound=OrderModel)
Answer = TypeVar("Answer")


def sign(flow: str, order: Order) -> Order:
    """The order with a signature for its flow, if it names a person; else as it is.

    Call it only for an authenticated person: one who is logged in, or works at this computer.
    Raises Unusable where this account may not read the key of the home.
    """
    person = _person(flow, order)
    if person is None:
        return order
    unsigned = {
        "person": person, "signed_at": datetime.now(UTC), "nonce": secrets.token_hex(16),
        "signed_on": f"{login()}@{socket.gethostname()}",
    }  # fmt: skip
    signature = signed(flow, _content(order), unsigned, execute.home_of(order))
    return order.model_copy(update={"signature": signature})


def carry_out_signed(work: Callable[[Order], Answer], order: Order) -> Answer:
    """Carries out an order of somebody who is logged in, in this process, as the flow would.

    work: a function of `flows.execute`.
    """
    order = sign(work.__name__, order)
    with accepted(work.__name__, order):
        return work(order)


@contextmanager
def accepted(flow: str, order: OrderModel) -> Iterator[None]:
    """Lets an order be carried out within it if it names nobody, or its signature holds.

    Raises Unusable, which is logged, for a signature that is missing, of another order, flow, home
    or person, too old, or used, and for a person whose role does not allow it.
    """
    person = _person(flow, order)
    if person is None:
        yield
        return
    place = execute.home_of(order)
    signature = _taken(flow, order, person, place)
    try:
        yield
    except Busy:
        raise  # the flow run may be tried again
    except Unusable:
        certificates.finish(signature, place)
        raise
    certificates.finish(signature, place)


def _taken(flow: str, order: OrderModel, person: str, place: Home) -> Signature:
    """The signature of an order, which nobody can use again."""
    subject = _subject(order)
    try:
        signature = _checked(flow, order, person, place)
        run = flow_run()
        if not certificates.take(signature, flow, plain(subject), run, place):
            raise Unusable(
                f"{flow} {plain(subject)}: the signature of this order was used already; give "
                "it anew"
            )
    except Busy:
        raise
    except Unusable as fault:
        known = place if (place.path / ORDER_KEY).is_file() else home()
        refused(known, flow, subject, claimed=person, why=fault, flow_run=flow_run())
        raise
    return signature


def _checked(flow: str, order: OrderModel, person: str, place: Home) -> Signature:
    """The signature of an order; Unusable for one that does not hold."""
    signature: Signature | None = getattr(order, "signature", None)
    what = f"{flow} {plain(_subject(order))}"
    if signature is None:
        raise Unusable(
            f"{what}: a name alone ({plain(person)}) gives no order; give it on the pages, or with "
            f"`mimucal {flow} --by NAME` from an account that may read {place.path / ORDER_KEY}"
        )
    if signature.person != person or not is_signed(flow, _content(order), signature, place):
        raise Unusable(
            f"{what}: the signature is not that of this order, flow, person ({plain(person)}) and "
            f"home ({place.path}); give the order anew"
        )
    age = datetime.now(UTC) - signature.signed_at
    if not -AHEAD <= age <= AGE:
        raise Unusable(
            f"{what}: signed at {signature.signed_at:%F %T %Z}, which is more than {AGE.days} days "
            "ago or still to come; give the order anew, and see that the clocks agree"
        )
    known = users(place)
    user = known.get(person)
    if known and not (user and Visitor(name=person, role=user.role).may(FLOWS[flow])):
        raise Unusable(
            f"{what}: {plain(person)} is no user of this home whose role allows it; `mimucal user "
            "list` names users and roles"
        )
    return signature


def _person(flow: str, order: OrderModel) -> str | None:
    """In whose name a flow would act; None for one that acts in nobody's."""
    person: str | None = getattr(order, "by", None) if flow in FLOWS else None
    return person


def _content(order: OrderModel) -> dict[str, Any]:
    return order.model_dump(mode="json", exclude={"signature"})


def _subject(order: OrderModel) -> str:
    return next(str(getattr(order, name)) for name in SUBJECTS if hasattr(order, name))


def flow_run() -> str | None:
    """The id of the flow run that is going on here."""
    if "prefect" not in sys.modules:
        return None
    from prefect.context import FlowRunContext

    context = FlowRunContext.get()
    return str(context.flow_run.id) if context and context.flow_run else None


# The key of the home that signs orders: whoever can read it can order in a person's name.

ORDER_KEY = "orders.key"


def signed(flow: str, order: dict[str, Any], unsigned: dict[str, Any], home: Home) -> Signature:
    """The signature of an order with the home's key, which is made where there is none yet.

    order: as JSON values, without a signature. unsigned: the fields of the signature but its mac.
    Raises Unusable where the key cannot be read, or can be by others.
    """
    draft = Signature(**unsigned, mac="0" * 64)
    key = whole_files.made(home.path / ORDER_KEY)
    return draft.model_copy(update={"mac": _mac(key, flow, order, draft)})


def is_signed(flow: str, order: dict[str, Any], signature: Signature, home: Home) -> bool:
    """Whether a signature is that of this order, for this flow, by the home's key.

    Raises Unusable where the key is missing, cannot be read, or can be by others.
    """
    key = whole_files.read(home.path / ORDER_KEY)
    return hmac.compare_digest(_mac(key, flow, order, signature), signature.mac)


def _mac(key: str, flow: str, order: dict[str, Any], signature: Signature) -> str:
    about = signature.model_dump(mode="json", exclude={"mac"})
    content = {"flow": flow, "order": order, "signature": about}
    text = json.dumps(content, ensure_ascii=True, sort_keys=True, separators=(",", ":"))
    return hmac.new(key.encode(), text.encode(), hashlib.sha256).hexdigest()
