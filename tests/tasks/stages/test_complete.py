"""A certificate states all that clause 8 asks for, or it is not issued; and says so beforehand."""

from collections.abc import Callable
from typing import Any

import pytest
from lxml import etree

from schemas.base import Unusable
from schemas.calibration import Method
from schemas.certificate import Certificate, State, Step
from storage.catalogue import certificates, results, runs
from storage.home import Home
from tasks.certificate.content import content
from tasks.certificate.mandatory import CLAUSE_8, MANDATORY, missing, unstated
from tasks.certificate.pdf import faces_of
from tasks.specifications.register import SPECIFICATIONS
from tasks.stages.certify import Published, keep_draft
from tasks.stages.issue import check, issue
from tasks.words import say
from tests.drafts import MORNING, STANDARD, calibration_of, certificate_of, recording_of

pytestmark = pytest.mark.usefixtures("unprinted")

Left = Callable[[Certificate], Certificate]


def changed(path: str, value: Any) -> Left:
    """The certificate with one field of it, however deep, replaced."""

    def change(part: Any, names: list[str]) -> Any:
        first, *rest = names
        new = change(getattr(part, first), rest) if rest else value
        return part.model_copy(update={first: new})

    return lambda made: change(made, path.split("."))


def both(path: str) -> Left:
    """Without a text in either language."""
    return lambda made: changed(f"{path}_zh", " ")(changed(path, "")(made))


def of_standard(**fields: str) -> Left:
    return changed("laboratory.equipment", (STANDARD.model_copy(update=fields),))


def values(**fields: Any) -> Left:
    def left(made: Certificate) -> Certificate:
        items = {
            name: item.model_copy(update=fields) for name, item in made.calibration.items.items()
        }
        return changed("calibration.items", items)(made)

    return left


LEFT_OUT: dict[str, Left] = {
    "laboratory": both("laboratory.party.name"),
    "laboratory-address": both("laboratory.party.address"),
    "client": both("order.client.name"),
    "client-address": both("order.client.address"),
    "manufacturer": changed("manifest.unit.manufacturer", " "),
    "model": changed("manifest.unit.model", ""),
    "serial": changed("manifest.unit.serial", ""),
    "received": changed("order", None),
    "calibrated": changed("calibrated_on", None),
    "standards": changed("laboratory.equipment", ()),
    "standard-name": of_standard(name="", name_zh=""),
    "standard-serial": of_standard(serial=""),
    "standard-accuracy": of_standard(accuracy=""),
    "standard-certificate": of_standard(certificate=" "),
    "temperature": changed("calibration.environment.temperature_degc", None),
    "humidity": changed("calibration.environment.humidity_percent", None),
    "results": values(value={"x": None}, U={"x": None}, u={"x": None}),
    "uncertainty": values(U={"x": None}),
    "issuer-title": lambda made: changed("laboratory.issuer_title", None)(
        changed("laboratory.issuer_title_zh", None)(made)
    ),
    "operator": changed("operator", None),
}
BY_A_STEP = {"issuer", "checker"}  # no certificate is issued without these steps
BOTH: tuple[Method, ...] = ("jjf2003", "jjf1536")


def drafted(home: Home, method: Method, left: Left = lambda made: made, **more: Any) -> Published:
    run, _ = runs.add(recording_of("1"), home)
    calibration = calibration_of(run, method=method)
    made = left(certificate_of(run, calibration, **more))
    results.save(made.calibration, home)
    return keep_draft(made, home, MORNING)


def at(made: Certificate, state: State) -> Certificate:
    """The certificate at a state, with the steps that lead there."""
    taken = {"draft": 1, "checked": 2, "issued": 3}[state]
    steps = [
        Step(step=step, person=person, at=MORNING)
        for step, person in (("draft", "Wang"), ("check", "Li"), ("issue", "Zhao"))
    ]
    return made.model_copy(update={"state": state, "steps": tuple(steps[:taken])})


def test_everything_mandatory_is_left_out_once_below():
    assert LEFT_OUT.keys() | BY_A_STEP == {each.name for each in CLAUSE_8}
    assert {SPECIFICATIONS[method].standard for method in BOTH} == set(MANDATORY)


@pytest.mark.parametrize("method", BOTH)
def test_a_certificate_that_states_everything_is_issued(home, method):
    draft = drafted(home, method)
    assert draft.missing == ()
    check(draft.certificate.number, home, "Li")
    done = issue(draft.certificate.number, home, "Zhao").certificate
    assert done.state == "issued"
    assert missing(done) == ()


@pytest.mark.parametrize(
    "method", ["jjf2003", pytest.param("jjf1536", marks=pytest.mark.rehearsal)]
)
@pytest.mark.parametrize("name", LEFT_OUT)
def test_what_is_left_out_is_listed_and_keeps_it_from_being_issued(home, name, method):
    draft = drafted(home, method, LEFT_OUT[name])
    listed = [say(each, "en") for each in draft.missing]
    required = next(each for each in CLAUSE_8 if each.name == name)
    assert say(required.sentence, "en") in listed
    with pytest.raises(Unusable, match="cannot be issued") as refused:
        check(draft.certificate.number, home, "Li")
    sentence = str(refused.value)
    assert say(required.what, "en") in sentence
    assert "--report" in sentence
    assert "\n" not in sentence
    (entry,) = certificates.register(home)
    assert entry.state == "draft"


@pytest.mark.parametrize("name", sorted(BY_A_STEP))
def test_a_step_that_nobody_took_is_missing(home, name):
    made = at(drafted(home, "jjf2003").certificate, "issued")
    step = {"issuer": "issue", "checker": "check"}[name]
    steps = tuple(each for each in made.steps if each.step != step)
    (absent,) = unstated(made.model_copy(update={"steps": steps}))
    assert absent.name == name


@pytest.mark.parametrize("method", BOTH)
def test_all_that_is_missing_is_said_at_once(home, method):
    def nothing(made: Certificate) -> Certificate:
        return made.model_copy(
            update={"laboratory": None, "order": None, "calibrated_on": None, "operator": None}
        )

    key = drafted(home, method, nothing).certificate.number
    with pytest.raises(Unusable, match="cannot be issued") as refused:
        check(key, home, "Li")
    for name in ("laboratory", "client", "received", "calibrated", "standards", "issuer-title",
                 "operator"):  # fmt: skip
        what = next(each.what for each in CLAUSE_8 if each.name == name)
        assert say(what, "en") in str(refused.value)


def everywhere(made: Certificate) -> dict[str, str]:
    """The texts of the page (both languages), of the DCC and of the record."""
    faces = faces_of(made, None)
    dcc = "\n".join(etree.fromstring(faces.dcc).itertext())
    return {"page": str(content(made)), "dcc": dcc, "record": faces.record.decode()}


def test_what_is_mandatory_stands_on_page_dcc_and_record(home):
    mandatory = {
        "Lab", "1 Road", "Client", "2 Road", "Maker", "2018-01-01", "2026-11-20", "Turntable",
        "TT-1", "C-1", "Sun", "Li", "Zhao", "Head of laboratory",
    }  # fmt: skip
    made = at(drafted(home, "jjf2003").certificate, "issued")
    for face, found in everywhere(made).items():
        assert {text for text in mandatory if text not in found} == set(), face


def test_a_report_is_issued_with_less_and_says_so(home):
    agreed = "order 4711 of 2026-11-02, clause 5"
    accredited = changed("laboratory.accreditation", "CNAS L1234")

    def less(made: Certificate) -> Certificate:
        return accredited(LEFT_OUT["humidity"](made))

    key = drafted(home, "jjf2003", less, report=agreed).certificate.number
    assert check(key, home, "Li").missing == ()
    made = issue(key, home, "Zhao").certificate
    printed = content(made)
    assert printed.is_report
    assert say(printed.title, "en") == "Calibration Report"
    (kind,) = [say(f.value, "en") for f in printed.front if f.label.id.endswith(".report")]
    assert kind == (
        "Simplified report by agreement with the client (ISO/IEC 17025, 7.8.1.3); not a "
        f"calibration certificate. Agreement: {agreed}. Not stated here: humidity during the "
        "calibration."
    )
    faces = everywhere(made)
    assert agreed in faces["dcc"]
    assert made.report == agreed
    assert "CNAS" not in faces["page"] + faces["dcc"].partition("mimu-certificate-record")[0]


def test_a_report_does_not_go_round_what_is_contradicted_or_out_of_date(home):
    late = of_standard(valid_until=MORNING.date().replace(year=2025))  # type: ignore[arg-type]
    key = drafted(home, "jjf2003", late, report="agreed").certificate.number
    with pytest.raises(Unusable, match="2025-11-21"):
        check(key, home, "Li")
