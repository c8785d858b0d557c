"""`mimucal demo`: the whole line on this machine, from the virtual station to a certificate."""

import json
import time
from importlib.resources import files
from pathlib import Path
from typing import Any

from flows.carry_out import import_flows
from flows.execute import procedure_of
from flows.on_prefect.server import connect
from flows.shown_results import print_calibration, print_verdict, summary
from flows.terminal import print_rows, working
from schemas.orders import ProduceOrder
from storage.home import Home, home
from storage.whole_files import writing_in_home
from tasks.stages.certify import Published
from tasks.station.virtual.config import truth, virtual_station
from tasks.station.virtual.servers import running

SPEED, AHRS_SPEED = 60.0, 300.0  # as fast as two cores can process: an AHRS sends less data


def run_demo(*, procedure: str, speed: float | None, seed: int, as_json: bool) -> None:
    """Run the line once on a virtual station and print the paths of everything it made.

    Raises Unusable for an unknown procedure.
    """
    began = time.monotonic()
    folder = home()
    station_file = folder.demo / "station.json"
    order = ProduceOrder(station=str(station_file), procedure=procedure, invalid_run=True)
    ahrs = procedure_of(order).standard == "JJF 1536-2015"
    config = virtual_station(seed, ahrs)
    _write_in_home(folder.demo / "truth.json", json.dumps(truth(config), indent=1))
    with working("starting Prefect"):
        connect(folder, import_flows)
        from flows.on_prefect import flows
    with running(config, speed or (AHRS_SPEED if ahrs else SPEED)) as station:
        _write_in_home(station_file, station.model_dump_json(indent=1))
        (draft,) = flows.run_now(flows.produce, order.model_copy(update=_certificate_files(ahrs)))
    made = _made(draft, folder)
    made["seconds"] = round(time.monotonic() - began, 1)
    if as_json:
        print(json.dumps(made, ensure_ascii=False, indent=1))
        return
    print_calibration(draft.certificate.calibration)
    print_verdict(draft)
    reminders = [(due["unit"], due["due"]) for due in made["reminders"]]
    print_rows("Recalibration, once it is issued", ("unit", "due"), reminders)
    for name, path in made["paths"].items():
        print(f"{name:<12} {path}")
    print(f"{made['seconds']} s")


def _write_in_home(path: Path, text: str) -> None:
    with writing_in_home(path):
        path.write_text(text + "\n", encoding="utf-8")


def _certificate_files(ahrs: bool) -> dict[str, str]:
    papers = files("flows") / "demo_papers"
    own = papers / "ahrs" if ahrs else papers
    return {
        "tolerance": str(own / "tolerance.toml"),
        "laboratory": str(papers / "laboratory.toml"),
        "client_order": str(own / "order.toml"),
    }


def _made(draft: Published, folder: Home) -> dict[str, Any]:
    """The files made by the demonstration, as one JSON document."""
    certificate, calibration = draft.certificate, draft.certificate.calibration
    named = certificate.manifest.unit
    unit = " ".join((named.manufacturer, named.model, named.serial))
    due = certificate.due.isoformat() if certificate.due else None
    return {
        "format": "mimu-demo/1",
        "run": calibration.run,
        "validity": summary(calibration.validity),
        "verdict": certificate.decision.verdict,
        "certificate": certificate.number,
        "due": due,
        "reminders": [{"unit": unit, "due": due}] if due else [],
        "paths": {
            "raw": str(folder.raw / f"{calibration.digest}.mcap"),
            "columns": str(folder.columns / calibration.digest),
            "certificate": str(draft.pdf),
            "record": str(draft.record),
            "station": str(folder.demo / "station.json"),
            "truth": str(folder.demo / "truth.json"),
        },
    }
