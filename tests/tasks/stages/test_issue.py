"""The life of a certificate: draft, checked, issued, amended or withdrawn, and in that order."""

import json
import re
from collections.abc import Callable
from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest
import sqlalchemy as sql

from schemas.access import Authorised
from schemas.base import Unusable
from schemas.calibration import AdoptedTerm
from schemas.certificate import Laboratory, Order, Replaced
from schemas.laboratory import MeasurementStandard
from schemas.orders import AmendOrder
from schemas.text import Remark
from schemas.tolerance import Decision
from storage.catalogue import audit_trail, certificates, database, results, runs, tables
from storage.catalogue.run_states import run_list
from storage.home import Home
from storage.verify import verify
from tasks.stages.authority import authorised_operator, why_not
from tasks.stages.certify import Published, keep_draft
from tasks.stages.issue import amendment, check, issue, withdraw
from tests.drafts import LABORATORY, MORNING, PARTY, calibration_of, certificate_of, draft

pytestmark = pytest.mark.usefixtures("unprinted")

NO_LIMITS = Decision(verdict="inconclusive", rule="simple", document=None, limits=())
TABLE = MeasurementStandard(
    name="Table", name_zh="转台", serial="7", accuracy="1″", certificate="C",
    valid_until=date(2026, 11, 19),
)  # fmt: skip


def issued(home: Home, serial: str = "1", **changes: object) -> Published:
    key = draft(home, serial, **changes).certificate.number
    check(key, home, "Li")
    return issue(key, home, "Zhao")


def refusal(step: Callable[..., object], *arguments: object) -> str:
    """The one sentence with which a step is refused."""
    with pytest.raises(Unusable) as refused:
        step(*arguments)
    sentence = str(refused.value)
    assert "\n" not in sentence
    assert sentence.endswith(".")
    return sentence


def test_a_draft_has_a_key_and_gets_its_number_at_issue(home):
    drafted = draft(home)
    run = runs.all_runs(home)[0].id
    assert (drafted.certificate.number, drafted.state) == (f"draft-{run[:8]}", "draft")
    checked = check(drafted.certificate.number, home, "Li", "all values read again")
    assert (checked.certificate.number, checked.state) == (drafted.certificate.number, "checked")
    done = issue(drafted.certificate.number, home, "Zhao")
    year = done.certificate.issued_on.year
    assert (done.certificate.number, done.state) == (f"LAB-{year}-0001", "issued")
    steps = [(step.step, step.person, step.reason) for step in done.certificate.steps]
    assert steps == [
        ("draft", "Wang", None), ("check", "Li", "all values read again"), ("issue", "Zhao", None)
    ]  # fmt: skip
    assert json.loads(done.record.read_bytes())["number"] == done.certificate.number
    assert sorted(path.stem for path in home.certificates.iterdir()) == [f"LAB-{year}-0001"] * 3
    assert [entry.action for entry in audit_trail.entries(home)] == ["draft", "check", "issue"]
    assert verify(home)[1] == []


def test_certifying_again_supersedes_the_draft_of_that_run_and_purpose(home):
    first = draft(home)
    check(first.certificate.number, home, "Li")
    second = draft(home, bias=0.5)
    assert second.certificate.number == first.certificate.number
    (entry,) = certificates.register(home)
    assert entry.state == "draft"
    assert len(list(home.certificates.iterdir())) == 3
    assert verify(home)[1] == []


def test_certificates_of_one_run_for_different_purposes_stand_side_by_side(home):
    draft(home)
    run = runs.all_runs(home)[0]
    joint = calibration_of(run, method="joint")
    other = keep_draft(certificate_of(run, joint), home, MORNING)
    assert other.certificate.number == f"draft-{run.id[:8]}-2"
    assert len(certificates.register(home)) == 2


def test_a_refused_issue_costs_no_number(home):
    key = draft(home, "1", decision=NO_LIMITS).certificate.number
    refusal(check, key, home, "Li")
    late = draft(home, "3").certificate.number
    check(late, home, "Li")
    newer = results.save(calibration_of(runs.all_runs(home)[-1], bias=0.5), home)
    assert newer in refusal(issue, late, home, "Zhao")
    assert issued(home, "2").certificate.number.endswith("-0001")


@pytest.mark.parametrize(
    ("taken", "step", "says"),
    [
        ((), issue, r"is a draft: `mimucal check \S+` comes first"),
        ((check,), check, r"is checked already: `mimucal issue \S+` comes next"),
        ((check, issue), issue, r"Draft \S+ is issued, as certificate LAB-\d+-0001"),
        ((check, issue), check, r"Draft \S+ is issued, as certificate LAB-\d+-0001"),
    ],
)
def test_a_step_out_of_order_is_refused(home, taken, step, says):
    key = draft(home).certificate.number
    for each, person in zip(taken, ("Li", "Zhao"), strict=False):
        each(key, home, person)
    assert re.search(says, refusal(step, key, home, "Sun"))


def test_only_an_issued_certificate_is_withdrawn_or_amended_and_only_once(home):
    key = draft(home).certificate.number
    assert "comes first" in refusal(withdraw, key, home, "Zhao", "an error")
    number = issued(home).certificate.number
    withdraw(number, home, "Zhao", "the table was wrong")
    assert "is withdrawn" in refusal(withdraw, number, home, "Zhao", "again")
    order = AmendOrder(certificate=number, by="Wang", why="an error")
    assert "is withdrawn" in refusal(amendment, order, home)


@pytest.mark.parametrize("person", ["Wang", " wang", "ＷＡＮＧ"])
def test_who_drafted_does_not_check(home, person):
    key = draft(home).certificate.number
    assert refusal(check, key, home, person).startswith(f"Wang drafted {key}, so another person")


@pytest.mark.parametrize(("person", "did"), [("Wang", "drafted"), ("Li", "checked")])
def test_who_drafted_or_checked_does_not_issue(home, person, did):
    key = draft(home).certificate.number
    check(key, home, "Li")
    assert refusal(issue, key, home, person).startswith(f"{person} {did} {key}")


def test_a_laboratory_may_allow_one_person_for_all(home):
    alone = LABORATORY.model_copy(update={"separate_persons": False})
    key = draft(home, laboratory=alone).certificate.number
    check(key, home, "Wang")
    assert issue(key, home, "Wang").state == "issued"


def test_the_homes_own_laboratory_goes_before_that_of_the_certificate(home):
    home.path.mkdir()
    party = "\n".join(f'{name} = "{text}"' for name, text in PARTY.model_dump().items())
    (home.path / "laboratory.toml").write_text(f"[party]\n{party}\n", encoding="utf-8")
    alone = LABORATORY.model_copy(update={"separate_persons": False})
    key = draft(home, laboratory=alone).certificate.number
    assert "another person" in refusal(check, key, home, "Wang")


def test_a_unit_without_limits_is_issued_only_where_the_order_asks_for_no_verdict(home):
    key = draft(home, decision=NO_LIMITS).certificate.number
    assert "there are no limits of Maker U" in refusal(check, key, home, "Li")
    order = Order(client=PARTY, received=date(2026, 11, 1), conformity=False)
    assert issued(home, "2", decision=NO_LIMITS, order=order).state == "issued"


def test_equipment_that_had_run_out_blocks_the_issue(home):
    laboratory = LABORATORY.model_copy(update={"equipment": (TABLE,)})
    key = draft(home, laboratory=laboratory).certificate.number
    assert "2026-11-19" in refusal(check, key, home, "Li")


def test_a_newer_result_of_the_run_blocks_the_issue(home):
    key = draft(home).certificate.number
    check(key, home, "Li")
    run = runs.all_runs(home)[0]
    newer = results.save(calibration_of(run, bias=0.5), home)
    assert f"which {newer} superseded; certify the run again" in refusal(issue, key, home, "Zhao")


def test_a_run_that_was_found_invalid_since_blocks_the_issue(home):
    key = draft(home).certificate.number
    check(key, home, "Li")
    wrong = Remark(code="clocks_apart", en="Two clocks.", zh="两个时钟。", run="invalid")
    results.save(calibration_of(runs.all_runs(home)[0], remarks=(wrong,)), home)
    assert "is invalid (Two clocks); measure again" in refusal(issue, key, home, "Zhao")


def test_a_result_with_a_term_beside_the_standard_s_does_not_judge_the_run(home):
    key = draft(home).certificate.number
    check(key, home, "Li")
    wrong = Remark(code="clocks_apart", en="Two clocks.", zh="两个时钟。", run="invalid")
    arm = AdoptedTerm(name="lever_arm", title="t", title_zh="t")
    run = runs.all_runs(home)[0]
    results.save(calibration_of(run, remarks=(wrong,), terms=(arm,)), home)
    (line,) = run_list([], [], 0, 1, home)[1]
    assert line.validity == "valid"
    assert issue(key, home, "Zhao").certificate.state == "issued"


def test_a_draft_whose_file_was_changed_is_not_issued(home):
    drafted = draft(home)
    key = drafted.certificate.number
    drafted.record.chmod(0o644)
    drafted.record.write_bytes(drafted.record.read_bytes().replace(b"0.25", b"0.24"))
    assert "was changed after it was kept" in refusal(check, key, home, "Li")


def test_an_amendment_is_checked_and_issued_and_then_replaces(home):
    old = issued(home).certificate
    run = runs.all_runs(home)[0]
    replaced = Replaced(number=old.number, issued_on=old.issued_on, why="the client's address")
    new = certificate_of(run, calibration_of(run), replaces=replaced)
    key = keep_draft(new, home, MORNING).certificate.number
    check(key, home, "Li")
    assert certificates.entry_of(old.number, home).state == "issued"
    number = issue(key, home, "Zhao").certificate.number
    assert number.endswith("-0002")
    before, after = certificates.register(home)
    assert (before.number, before.state) == (old.number, "amended")
    assert (after.supersedes, after.why) == (old.number, "the client's address")
    assert certificates.find(old.number, home) == old
    assert [line.certificate for line in certificates.due(home, date(2030, 1, 1))] == [number]
    assert verify(home)[1] == []


def test_an_amendment_takes_over_what_it_does_not_say(home):
    order = Order(client=PARTY, received=date(2026, 11, 1), interval_months=6)
    old = issued(home, order=order).certificate
    new = amendment(AmendOrder(certificate=old.number, by="Sun", why="a digit"), home)
    assert (new.run, new.as_found) == (old.calibration.run, None)
    assert (new.inputs.order, new.inputs.laboratory, new.inputs.by) == (order, LABORATORY, "Sun")
    assert (new.inputs.tolerance, new.inputs.operator) == (old.tolerance, old.operator)
    assert new.inputs.calibrated_on == old.calibrated_on
    assert new.replaces == Replaced(number=old.number, issued_on=old.issued_on, why="a digit")


def test_a_draft_that_amends_gives_way_where_what_it_amends_is_withdrawn(home):
    old = issued(home).certificate
    run = runs.all_runs(home)[0]
    replaced = Replaced(number=old.number, issued_on=old.issued_on, why="an error")
    for _ in range(2):  # again, it takes the place of the first
        keep_draft(certificate_of(run, calibration_of(run), replaces=replaced), home, MORNING)
    assert len(certificates.register(home)) == 2
    assert "`mimucal amend" in refusal(draft, home)
    withdraw(old.number, home, "Zhao", "an error")
    draft(home)
    assert [entry.supersedes for entry in certificates.register(home)] == [None, None]


def test_a_draft_of_an_earlier_version_gives_way_and_is_not_issued(home):
    key = draft(home).certificate.number
    with database.changing(home) as connection:
        connection.execute(sql.delete(tables.decisions))
        connection.execute(sql.update(tables.certificates).values(number="LAB-1", purpose=None))
    assert "drafted by an earlier version" in refusal(check, "LAB-1", home, "Li")
    draft(home)
    states = {entry.number: entry.state for entry in certificates.register(home)}
    assert states == {"LAB-1": "withdrawn", key: "draft"}


def test_an_issue_that_fails_leaves_everything_as_it_was(home, monkeypatch):
    key = draft(home).certificate.number
    check(key, home, "Li")

    def full(*_: object, **__: object) -> None:
        raise Unusable("the disk is full.")

    with monkeypatch.context() as broken:
        broken.setattr(audit_trail, "add", full)  # after the files were written
        refusal(issue, key, home, "Zhao")
    (entry,) = certificates.register(home)
    assert (entry.number, entry.state) == (key, "checked")
    assert issue(key, home, "Zhao").certificate.number.endswith("-0001")
    assert verify(home)[1] == []


# Who may acquire, check and issue, for which specification and until when.

TODAY = datetime.now(UTC).astimezone().date()
DAY = date(2026, 11, 20)  # of the calibration of `draft`
MIMU, AHRS = "JJF 2003-2022", "JJF 1536-2015"


def with_persons(*persons: Authorised) -> Laboratory:
    return LABORATORY.model_copy(update={"authorised": persons})


def person(name: str, *may: Any, **more: Any) -> Authorised:
    return Authorised(name=name, may=may, **more)


SUN = person("Sun", "acquire", standards=(MIMU,), until=date(2026, 12, 31))


@pytest.mark.parametrize(
    ("name", "act", "standard", "day", "says"),
    [
        ("Sun", "acquire", MIMU, DAY, None),
        ("Sun", "acquire", MIMU, date(2026, 12, 31), None),
        ("Sun", "acquire", MIMU, date(2027, 1, 1), "until 2026-12-31, before 2027-01-01"),
        ("Sun", "acquire", AHRS, DAY, "authorised to acquire by JJF 2003-2022, not by JJF 1536"),
        ("Sun", "issue", MIMU, DAY, "authorised to acquire, not to issue"),
        ("Qian", "acquire", MIMU, DAY, "authorised to nothing, not to acquire"),
        (None, "acquire", MIMU, DAY, "nobody is named"),
    ],
)
def test_a_person_acts_within_the_authorisation(name, act, standard, day, says):
    why = why_not(with_persons(SUN), name, act, standard, day)
    assert says is why if says is None else why is not None and says in why


def test_where_nobody_is_named_everybody_may():
    assert why_not(LABORATORY, "anybody", "issue", MIMU, DAY) is None
    assert why_not(None, None, "acquire", MIMU, DAY) is None


def test_an_acquisition_is_refused_before_it_begins():
    laboratory = with_persons(person("Wang", "acquire"))
    assert authorised_operator(None, MIMU, laboratory) == "Wang"  # operator of laboratory.toml
    with pytest.raises(Unusable, match=r"Qian is authorised to nothing, not to acquire; .*--by"):
        authorised_operator("Qian", MIMU, laboratory)


def persons_of_home(home: Home, *persons: tuple[str, str, date | None]) -> None:
    """The home's laboratory.toml: what each person may do, and until when."""
    lines = [f'{name} = "{text}"' for name, text in LABORATORY.party.model_dump().items()]
    text = "[party]\n" + "\n".join(lines) + "\n"
    for name, may, until in persons:
        text += f'[[authorised]]\nname = "{name}"\ntitle = "Dr"\nmay = ["{may}"]\n'
        text += f"until = {until}\n" if until else ""
    home.path.mkdir(parents=True, exist_ok=True)
    (home.path / "laboratory.toml").write_text(text, encoding="utf-8")


def test_check_and_issue_are_refused_to_whoever_may_not(home):
    key = draft(home).certificate.number
    ended = TODAY - timedelta(days=1)
    persons = (("Sun", "acquire", DAY), ("Li", "check", None), ("Zhao", "issue", None))
    persons_of_home(home, *persons, ("Zhou", "issue", ended))
    with pytest.raises(Unusable, match="Zhao is authorised to issue, not to check"):
        check(key, home, "Zhao")
    check(key, home, "Li")
    with pytest.raises(Unusable, match=f"Zhou was authorised to issue .* until {ended}"):
        issue(key, home, "Zhou")
    done = issue(key, home, "Zhao").certificate
    step = done.step("issue")
    assert step is not None
    assert step.title == "Dr"
    assert "authorised" not in done.model_dump_json()  # not a matter of the client


def test_a_measurement_by_whoever_was_not_authorised_on_its_day_is_not_issued(home):
    key = draft(home).certificate.number
    before = DAY - timedelta(days=1)
    persons_of_home(home, ("Sun", "acquire", before), ("Li", "check", None), ("Z", "issue", None))
    with pytest.raises(Unusable, match=f"Sun was authorised to acquire .* until {before}"):
        check(key, home, "Li")
