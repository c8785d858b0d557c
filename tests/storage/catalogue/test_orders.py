"""Production orders: kept under their number, begun once, and never lost with a process."""

from datetime import UTC, datetime, timedelta
from itertools import chain
from typing import Any

import pytest

from schemas.base import Unusable
from schemas.certificate import Order
from schemas.orders import ProductionOrder
from schemas.recording import Unit
from storage.catalogue import audit_trail, orders, runs
from storage.stations import only_worker_of
from tests.storage.small import small

NOW = datetime(2026, 11, 27, 8, tzinfo=UTC)
CLIENT = Order.model_validate({
    "received": "2026-11-20", "interval_months": 12,
    "client": {"name": "C", "name_zh": "客户", "address": "A", "address_zh": "地址"},
})  # fmt: skip
CLAIM = """
from storage.catalogue import orders
print([number for number in map(str, range(20)) if orders.claim(number, home)])
"""


def order(number: str = "1", **changes: Any) -> ProductionOrder:
    unit = Unit.model_validate({"manufacturer": "Maker", "model": "U", "serial": f"S{number}"})
    fields: dict[str, Any] = {
        "number": number, "station": "T1", "units": (unit,), "procedure": "jjf2003",
        "client_order": CLIENT, "person": "Li", "ordered_at": NOW,
    }  # fmt: skip
    return ProductionOrder(**fields | changes)


def test_an_order_is_kept_as_it_was_given_and_twice_the_same_is_one(fresh):
    assert orders.add([order()], fresh) == [(order(), True)]
    again = order(person="Zhao", ordered_at=NOW + timedelta(hours=1))
    assert orders.add([again], fresh) == [(order(), False)]
    assert orders.listed(fresh) == [order()]
    assert [(e.person, e.action, e.subject) for e in audit_trail.entries(fresh)] == [
        ("Li", "order acquire", "1")
    ]


@pytest.mark.parametrize(
    "changes",
    [{"station": "T2"}, {"procedure": "jjf1536"}, {"units": order("2").units},
     {"client_order": None}],
)  # fmt: skip
def test_another_content_under_a_number_is_refused_and_nothing_beside_it_is_kept(changes, fresh):
    orders.add([order()], fresh)
    what = next(iter(changes)).replace("_", " ")
    with pytest.raises(Unusable, match=f"order 1 is there already .* another {what}: give it"):
        orders.add([order("2"), order(**changes)], fresh)
    assert [each.number for each in orders.listed(fresh)] == ["1"]
    assert len(audit_trail.entries(fresh)) == 1


def test_of_four_processes_that_claim_twenty_orders_each_order_has_one(either, at_once):
    orders.add([order(str(number)) for number in range(20)], either)
    claimed = [eval(text) for text in at_once(CLAIM, either, processes=4)]
    assert sorted(chain(*claimed), key=int) == [str(number) for number in range(20)]
    assert {each.attempts for each in orders.listed(either)} == {1}
    orders.put_back("T1", either)
    assert [each.is_interrupted for each in orders.waiting(either)] == [True] * 20


def test_an_order_that_runs_or_has_ended_is_neither_claimed_nor_cancelled(fresh):
    orders.add([order()], fresh)
    claimed = orders.claim("1", fresh)
    assert claimed is not None
    assert (claimed.state, claimed.attempts, claimed.is_interrupted) == ("running", 1, False)
    assert orders.claim("1", fresh) is None
    with pytest.raises(Unusable, match="order 1 is running and waits no more: stop its run"):
        orders.cancel("1", "Li", fresh)
    orders.note("1", fresh, certificates=("draft-1",))
    orders.finish("1", "done", fresh)
    assert orders.claim("1", fresh) is None
    assert orders.put_back("T1", fresh) == []
    done = orders.find("1", fresh)
    assert (done.state, done.certificates, done.fault) == ("done", ("draft-1",), None)
    with pytest.raises(Unusable, match="only one that failed or was cancelled"):
        orders.retry("1", "Li", fresh)


def test_a_cancelled_order_waits_no_more_until_it_is_repeated(fresh):
    orders.add([order("1"), order("2", ordered_at=NOW + timedelta(seconds=1))], fresh)
    assert orders.cancel("1", "Zhao", fresh).state == "cancelled"
    assert [each.number for each in orders.waiting(fresh, "T1")] == ["2"]
    assert orders.waiting(fresh, "T2") == []
    assert orders.retry("1", "Zhao", fresh).state == "waiting"
    assert [each.number for each in orders.waiting(fresh, "T1")] == ["1", "2"]
    assert [entry.action for entry in audit_trail.entries(fresh)][2:] == [
        "cancel order",
        "order acquire",
    ]
    with pytest.raises(Unusable, match="there is no order '3'"):
        orders.cancel("3", "Zhao", fresh)


def test_an_order_whose_process_died_waits_again_and_goes_on_where_it_was(fresh):
    orders.add([order(), order("2", station="T2")], fresh)
    begun = orders.claim("1", fresh)
    orders.claim("2", fresh)
    assert [each.number for each in orders.put_back("T1", fresh)] == ["1"]
    assert orders.find("2", fresh).state == "running"
    again = orders.claim("1", fresh)
    assert begun is not None
    assert again is not None
    assert (again.is_interrupted, again.attempts) == (True, 2)
    assert again.began_at == begun.began_at
    assert orders.stored_since(again, fresh) == ()
    run, _ = runs.add(small(serial="S1"), fresh)
    runs.add(small(1.0, serial="S2"), fresh)
    assert orders.stored_since(again, fresh) == (run.id,)
    assert (
        orders.stored_since(again.model_copy(update={"began_at": datetime.now(UTC)}), fresh) == ()
    )


def test_one_process_takes_the_orders_of_a_station(fresh):
    first, second, other = (only_worker_of(name, fresh) for name in ("T1", "T1", "T2"))
    with first as is_first, second as is_second, other as is_other:
        assert (is_first, is_second, is_other) == (True, False, True)
