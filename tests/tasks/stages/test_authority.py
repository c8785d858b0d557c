"""Who may acquire, check and issue, for which specification and until when."""

from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest

from schemas.access import Authorised
from schemas.base import Unusable
from schemas.certificate import Laboratory
from storage.home import Home
from tasks.stages.authority import authorised_operator, why_not
from tasks.stages.issue import check, issue
from tests.drafts import LABORATORY, draft

pytestmark = pytest.mark.usefixtures("unprinted")

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
def test_a_person_acts_within_the_authorisation(name, act, standard, day, says) -> None:
    why = why_not(with_persons(SUN), name, act, standard, day)
    assert says is why if says is None else why is not None and says in why


def test_where_nobody_is_named_everybody_may() -> None:
    assert why_not(LABORATORY, "anybody", "issue", MIMU, DAY) is None
    assert why_not(None, None, "acquire", MIMU, DAY) is None


def test_an_acquisition_is_refused_before_it_begins() -> None:
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


def test_check_and_issue_are_refused_to_whoever_may_not(home: Home) -> None:
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


def test_a_measurement_by_whoever_was_not_authorised_on_its_day_is_not_issued(home: Home) -> None:
    key = draft(home).certificate.number
    before = DAY - timedelta(days=1)
    persons_of_home(home, ("Sun", "acquire", before), ("Li", "check", None), ("Z", "issue", None))
    with pytest.raises(Unusable, match=f"Sun was authorised to acquire .* until {before}"):
        check(key, home, "Li")
