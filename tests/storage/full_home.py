"""A home whose catalogue has rows in every table, as this version writes it.

`python -m tests.storage.full_home` packs it as `homes/REVISION.tar.xz`. A release's home is packed
before the release and stays: `test_earlier_homes` upgrades each of them.
"""

import tarfile
from contextlib import chdir
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest import mock

from schemas.certificate import Certificate, Signature
from schemas.discrepancy import (
    Detection,
    Discrepancy,
    EvidenceFor,
    FoundParameter,
    HeldOut,
    ReportedFinding,
)
from schemas.orders import ProductionOrder
from schemas.recording import Manifest, Unit
from schemas.text import Statement
from storage.catalogue import (
    certificates,
    database,
    discrepancies,
    equipment,
    orders,
    results,
    runs,
    users,
)
from storage.catalogue.runs import Run
from storage.formats.mcap.writer import write_mcap
from storage.home import Home
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.register import JJF2003
from tasks.stages.issue import check, issue, withdraw
from tests import drafts
from tests.ideal import ideal_run

HOMES = Path(__file__).parent / "homes"
GRAVITY = 9.8  # m/s², of the ideal run
NOW = datetime(2026, 11, 28, 8, tzinfo=UTC)
ANSWER = Statement(en="The table is tilted.", zh="转台倾斜。")


def fill(home: Home) -> None:
    """An ideal run with two results, one of them made again; certificates in every state; what
    `explain` found, an order that waits, a user who logged in, and a reminder.
    """
    equipment.add([drafts.STANDARD], home, "Wang")
    run = _ideal(home)
    calibration = calibrate(JJF2003, runs.load(run, home), run=run.id, code_version="1")
    first = results.save(calibration, home)
    again = calibration.model_copy(update={"code_version": "2"})
    results.save(again, home, why="a new version")
    made = results.ToMake(run=run, before=first)
    results.keep_fault(made, "the disk was full", "circumstances", 1.0, home)
    with mock.patch("tasks.certificate.pdf.render", _pdf):
        for serial in ("1", "2", "3", "4"):
            key = drafts.draft(home, serial).certificate.number
            if serial > "1":
                check(key, home, "Li")
            if serial > "2":
                issued = issue(key, home, "Zhao").certificate.number
    withdraw(issued, home, "Zhao", "the wrong unit")
    number = next(e.number for e in certificates.register(home) if e.state == "issued")
    key = (number, -30, "mail")
    equipment.claim(home, key, NOW, lambda tries: timedelta(hours=tries))
    equipment.note(home, key, NOW, "no answer")
    discrepancies.keep(run, _explained(), "<p>The table is tilted.</p>", NOW, home)
    orders.add([_order()], home)
    users.add("li", "verifier", "$argon2id$none", home, "Wang")
    users.end(users.begin("li", "192.0.2.1", home), "192.0.2.1", home)
    signature = Signature(
        person="Li", signed_at=NOW, nonce="0" * 32, signed_on="li@bench", mac="0" * 64
    )
    certificates.take(signature, "certify", run.id, "flow run", home)


def _ideal(home: Home) -> Run:
    recording = ideal_run(dwell=1.0, gravity=GRAVITY)
    used = {"name": "Turntable", "serial": "TT-1", "certificate": "C-1", "accuracy": "1″"}
    fields = recording.manifest.model_dump() | {
        "recorded_at": NOW.isoformat(),
        "equipment": [used | {"name_zh": "转台"}],
    }
    recording = replace(recording, manifest=Manifest.model_validate(fields))
    with TemporaryDirectory() as folder, chdir(folder):  # a path that is no machine's own
        source = Path("ideal.mcap")
        write_mcap(recording, source)
        return runs.add(recording, home, source=source)[0]


def _pdf(certificate: Certificate, **_: object) -> bytes:
    return b"%PDF " + certificate.number.encode()


def _order() -> ProductionOrder:
    unit = Unit.model_validate({"manufacturer": "Maker", "model": "U", "serial": "5"})
    return ProductionOrder(
        number="1", station="T1", units=(unit,), procedure="jjf2003", client_order=drafts.ORDER,
        person="Li", ordered_at=NOW,
    )  # fmt: skip


def _explained() -> Discrepancy:
    tilt = FoundParameter(name="east", value=1e-4, unit="rad", u=1e-5)
    finding = ReportedFinding(
        effect="axis_tilt", family="table", title=ANSWER, channels=("accel_x",), where=(),
        parameters=(tilt,), evidence=EvidenceFor(delta_bic=10.0, held_out_gain_nats=1.0),
        share=0.9, homogeneity_p=None, group=None, equation="", source="", next=ANSWER,
        statement=ANSWER,
    )  # fmt: skip
    return Discrepancy(
        recording_id="ideal", code_version="1", model=ANSWER, verdict="explained",
        detection=Detection(p_value=0.1, false_alarm_rate=0.005), explained_share=1.0,
        left_over={}, findings=(finding,), statement=ANSWER,
        held_out=HeldOut(rms_ratio={}, chi2_per_dof_before=1.0, chi2_per_dof_after=1.0),
    )  # fmt: skip


def _nobodys(member: tarfile.TarInfo) -> tarfile.TarInfo:
    return member.replace(uid=0, gid=0, uname="", gname="", deep=False)


def main() -> None:
    with TemporaryDirectory() as folder:
        home = Home(Path(folder) / "home")
        fill(home)
        with tarfile.open(HOMES / f"{database.HEAD}.tar.xz", "w:xz") as archive:
            archive.add(home.path, ".", filter=_nobodys)


if __name__ == "__main__":
    main()
