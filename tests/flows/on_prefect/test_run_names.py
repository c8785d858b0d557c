"""What flow runs are called."""

from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import pytest

from flows.on_prefect import run_names
from schemas.certificate_orders import ProduceOrder
from schemas.production import ProductionOrder
from schemas.recording import Unit
from storage.catalogue import orders
from storage.home import Home


def test_a_run_of_the_queue_is_called_by_the_unit_and_procedure_of_its_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not by the unit that the station file names, which was mounted when it was written."""
    made = ProductionOrder(
        number="1", station="A", units=(Unit(manufacturer="M", model="U", serial="S7"),),
        procedure="/lab/short.json", person="Wang", ordered_at=datetime.now(UTC),
    )  # fmt: skip
    orders.add([made], Home(tmp_path))
    order = ProduceOrder(home=str(tmp_path), station="A", number="1")
    monkeypatch.setattr(run_names, "flow_run", SimpleNamespace(parameters={"order": order}))
    assert run_names.of_acquisition() == "S7 short"
