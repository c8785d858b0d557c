"""Reminders that arrive: once, at a real mail server, with a calendar entry that others read."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, date, datetime, time, timedelta
from email import message_from_bytes, policy
from email.message import EmailMessage
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
import vobject
from aiosmtpd.controller import Controller
from aiosmtpd.smtp import AuthResult

from schemas.base import Unusable
from schemas.certificate import AsFound, Certificate, Order, Party
from schemas.tolerance import Decision
from storage.catalogue import equipment, results, runs
from storage.home import Home
from tasks.stages import remind
from tasks.stages.certify import keep_draft
from tasks.stages.issue import check, issue, withdraw
from tasks.stages.remind import interval_advice, sentence
from tasks.words import say
from tests.drafts import DECIDED, MORNING, calibration_of, certificate_of, draft, recording_of

pytestmark = pytest.mark.usefixtures("unprinted")

CLIENT = Party(name="Client & Co", name_zh="客户", address="a", address_zh="址")
OTHER = Party(name="Other", name_zh="他", address="a", address_zh="址")
DUE = date.today() + timedelta(days=400)


def order(client: Party = CLIENT, months: int | None = 12) -> Order:
    return Order(client=client, received=date(2026, 11, 1), interval_months=months)


class Mailbox:
    """What a mail server took in."""

    def __init__(self) -> None:
        self.letters: list[EmailMessage] = []

    async def handle_DATA(self, server: Any, session: Any, envelope: Any) -> str:  # noqa: N802
        letter = message_from_bytes(envelope.content, policy=policy.default)
        assert isinstance(letter, EmailMessage)
        self.letters.append(letter)
        return "250 taken"


@pytest.fixture
def mailbox() -> Mailbox:
    return Mailbox()


def mail_server(mailbox: Mailbox, port: int) -> Controller:
    controller = Controller(mailbox, hostname="127.0.0.1", port=port)
    controller.start()
    return controller


@pytest.fixture
def server(mailbox, free_port) -> Iterator[int]:
    """The port of a mail server that runs."""
    controller = mail_server(mailbox, free_port)
    yield free_port
    controller.stop(no_assert=True)


@pytest.fixture
def free_port() -> int:
    import socket

    with socket.create_server(("127.0.0.1", 0)) as listener:
        return int(listener.getsockname()[1])


def recall_file(home: Home, url: str, more: str = "") -> None:
    home.path.mkdir(exist_ok=True)
    text = f'{more}\n[[clients]]\nname = "Client & Co"\n[clients.channels]\ne-mail = "{url}"\n'
    (home.path / "recall.toml").write_text(text, encoding="utf-8")


def mail_to(port: int) -> str:
    return f"mailto://127.0.0.1:{port}?from=lab@example.org&to=client@example.org&mode=insecure"


def issued(home: Home, serial: str = "1", ordered: Order | None = None) -> str:
    key = draft(home, serial, order=ordered or order(), due=DUE).certificate.number
    check(key, home, "Li")
    return issue(key, home, "Zhao").certificate.number


def at(days: int, clock: time = time(12)) -> datetime:
    """A moment on a day so many after the due date."""
    return datetime.combine(DUE + timedelta(days=days), clock, UTC)


class Outbox:
    """Stands in for a channel, and keeps what is sent."""

    def __init__(self) -> None:
        self.titles: list[str] = []

    def __call__(self, url: str, title: str, body: str, entry: bytes) -> None:
        self.titles.append(title)


def test_a_mail_server_receives_the_reminder_and_its_entry_is_read_by_another_parser(
    home, server, mailbox
):
    number = issued(home)
    recall_file(home, mail_to(server))
    assert remind.remind(home, at(-60)) == []
    (letter,) = mailbox.letters
    assert "client@example.org" in letter["To"]
    assert letter["Subject"] == f"Recalibration of Maker U 1 due on {DUE}"
    text = letter.get_body(("plain",))
    assert text is not None
    assert number in text.get_content()
    (attached,) = letter.iter_attachments()
    assert attached.get_content_type() == "text/calendar"
    assert attached.get_filename() == "recalibration.ics"
    content = attached.get_payload(decode=True)
    assert isinstance(content, bytes)
    read = vobject.readOne(content.decode())
    assert (read.method.value, read.vevent.dtstart.value) == ("PUBLISH", DUE)
    assert read.vevent.summary.value == "Recalibration of Maker U 1 due"
    assert number in read.vevent.uid.value


def test_a_server_that_is_down_for_an_hour_gets_it_later_and_once(home, mailbox, free_port):
    issued(home)
    recall_file(home, mail_to(free_port))
    down = [remind.remind(home, at(-30, time(9, minute))) for minute in range(0, 60, 10)]
    assert "Maker U 1 to Client & Co e-mail: " in down[0][0]
    controller = mail_server(mailbox, free_port)
    try:
        for hour in (10, 11, 12):
            for minute in range(0, 60, 10):
                assert remind.remind(home, at(-30, time(hour, minute))) == []
    finally:
        controller.stop(no_assert=True)
    assert len(mailbox.letters) == 1
    (kept,) = equipment.all_reminders(home)
    assert kept.sent_at is not None
    assert (kept.fault, kept.tries) == (None, 1 + len([faults for faults in down if faults]))


def test_each_occasion_is_sent_once_and_only_the_last_that_has_come(home):
    issued(home)
    recall_file(home, mail_to(25))
    outbox = Outbox()
    for days in (-70, -60, -59, -31, -30, -8, -7, 0, 6, 7, 29, 30, 40):
        assert remind.remind(home, at(days), outbox) == []
    assert ["was due" in title for title in outbox.titles] == [False] * 3 + [True] * 2
    (lines,) = remind.sent(home).values()
    assert [line.split(", ")[1] for line in lines] == [
        "60 days before", "30 days before", "7 days before", "7 days after", "30 days after",
    ]  # fmt: skip


def test_of_many_at_once_one_sends(home):
    issued(home)
    recall_file(home, mail_to(25))
    outbox, together = Outbox(), threading.Barrier(6)

    def ask() -> None:
        together.wait()
        remind.remind(home, at(-7), outbox)

    threads = [threading.Thread(target=ask) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(outbox.titles) == 1


def test_nothing_is_sent_in_silent_hours_and_it_is_sent_after_them(home):
    issued(home)
    silent = '[silent]\nsince = 21:00:00\nuntil = 08:00:00\ntimezone = "Asia/Shanghai"'
    recall_file(home, mail_to(25), silent)
    outbox = Outbox()
    assert remind.remind(home, at(-7, time(15)), outbox) == []  # 23:00 in Shanghai
    assert outbox.titles == []
    assert remind.remind(home, at(-6, time(1)), outbox) == []
    assert len(outbox.titles) == 1


def test_a_draft_one_without_an_agreed_interval_and_one_withdrawn_are_not_due(home):
    draft(home, "1", order=order(), due=DUE)
    issued(home, "3", order(months=None))
    withdraw(issued(home, "4"), home, "Zhao", "wrong unit")
    number = issued(home, "5")
    assert [each.certificate for each in remind.due_units(home)] == [number]


def test_the_feed_of_a_client_holds_its_units_and_no_other_ones(home):
    for serial, client in (("1", CLIENT), ("2", CLIENT), ("3", OTHER)):
        issued(home, serial, order(client))
    read = vobject.readOne(remind.feed(home, "Client & Co", at(-100)).decode())
    assert sorted(event.summary.value for event in read.vevent_list) == [
        "Recalibration of Maker U 1 due", "Recalibration of Maker U 2 due",
    ]  # fmt: skip
    assert {event.dtstart.value for event in read.vevent_list} == {DUE}
    with pytest.raises(Unusable, match="No client 'Nobody'"):
        remind.feed(home, "Nobody", at(-100))


PASSWORDS = ["%41", "@/#?%:&=+ %40'\"$"]


@contextmanager
def asking_for_a_password(mailbox: Mailbox, port: int) -> Iterator[list[tuple[bytes, bytes]]]:
    """A mail server that takes any login; what it was given."""
    given: list[tuple[bytes, bytes]] = []

    def authenticate(server: Any, session: Any, envelope: Any, how: str, login: Any) -> AuthResult:
        given.append((login.login, login.password))
        return AuthResult(success=True)

    controller = Controller(
        mailbox, hostname="127.0.0.1", port=port, authenticator=authenticate,
        auth_require_tls=False, auth_required=True,
    )  # fmt: skip
    controller.start()
    try:
        yield given
    finally:
        controller.stop(no_assert=True)


without_tls = pytest.mark.filterwarnings("ignore:Requiring AUTH while not requiring TLS")


@without_tls
@pytest.mark.parametrize("password", PASSWORDS)
def test_the_mail_server_gets_a_password_of_any_characters(
    home, mailbox, free_port, password, monkeypatch,
    capfd
):  # fmt: skip
    issued(home)
    monkeypatch.setenv("MAIL_PASSWORD", password)
    recall_file(home, mail_to(free_port).replace("://", "://lab@example.org:${MAIL_PASSWORD}@"))
    (away,) = remind.remind(home, at(-30))
    with asking_for_a_password(mailbox, free_port) as given:
        assert remind.remind(home, at(-30, time(13))) == []
    assert given == [(b"lab@example.org", password.encode())]
    assert len(mailbox.letters) == 1
    shown = capfd.readouterr()
    for text in (away, shown.out, shown.err):
        assert password not in text or len(password) == 1


@without_tls
def test_a_password_that_no_mail_server_can_be_told_is_a_sentence_without_it(
    home, mailbox, free_port, monkeypatch
):
    issued(home)
    monkeypatch.setenv("MAIL_PASSWORD", "密secret")
    recall_file(home, mail_to(free_port).replace("://", "://lab:${MAIL_PASSWORD}@"))
    with asking_for_a_password(mailbox, free_port):
        (fault,) = remind.remind(home, at(-30))
    assert "beyond ASCII" in fault
    assert "secret" not in fault


@pytest.mark.parametrize("password", ["j%k:l", "n@o/p?q#"])
def test_a_password_written_as_it_is_becomes_no_host(home, password, capfd):
    url = f"mailto://lab:{password}@mail.example.org:25?from=lab@example.org&to=c@example.org"
    whole = remind.check_channel("e-mail", url)
    assert urlsplit(whole).hostname == "mail.example.org"
    assert unquote(urlsplit(whole).password or "") == password
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("url", "says"),
    [("nonsense", "is not an Apprise URL"), ("slack://${NOT_SET}", "NOT_SET.* is not set")],
)
def test_a_channel_that_is_none_is_said_before_anything_is_sent(home, url, says):
    issued(home)
    recall_file(home, url)
    with pytest.raises(Unusable, match=says):
        remind.remind(home, at(-7), Outbox())


# Advice on the interval of a unit from its own issued certificates.

FAILED = Decision(verdict="fail", rule="simple", document="Data sheet", limits=DECIDED.limits)
UNDECIDED = DECIDED.model_copy(update={"verdict": "inconclusive"})


def issued_interval(
    home: Home, year: int, decision: Decision = DECIDED, **changes: object
) -> Certificate:
    """A certificate of unit 7 from a calibration on 1 March of a year."""
    recording = recording_of("7")
    manifest = recording.manifest.model_copy(update={"recording_id": f"of {year}"})
    other = type(recording)(manifest, recording.imu)
    run, _ = runs.add(other, home)
    calibration = calibration_of(run)
    results.save(calibration, home)
    days: dict[str, object] = {"calibrated_on": date(year, 3, 1), "due": date(year + 1, 3, 1)}
    made = certificate_of(run, calibration, decision=decision, **(days | changes))
    key = keep_draft(made, home, MORNING).certificate.number
    check(key, home, "Li")
    return issue(key, home, "Zhao").certificate


def test_the_verdict_as_found_counts_and_what_was_inconclusive_does_not(home):
    issued_interval(home, 2018)
    issued_interval(home, 2019)
    issued_interval(home, 2020, UNDECIDED)
    issued_interval(home, 2021)
    as_left = issued_interval(home, 2022)
    found = AsFound(
        calibrated_on=date(2023, 2, 28), calibration=as_left.calibration, decision=FAILED
    )
    issued_interval(home, 2023, as_found=found)
    unit, agreed, advice = interval_advice("7", home)
    assert (unit, agreed) == ("Maker U 7", 366)
    assert (advice.intervals, advice.conforming, advice.advice) == (4, 3, "shorten")
    text = sentence(unit, agreed, advice)
    assert "within its limits after 3 of 4 intervals" in say(text, "en")
    assert "应予缩短" in say(text, "zh")


def test_a_young_unit_keeps_its_interval(home):
    issued_interval(home, 2024)
    issued_interval(home, 2025)
    unit, agreed, advice = interval_advice("7", home)
    assert "too few for the reliability method" in say(sentence(unit, agreed, advice), "en")


def test_without_an_agreed_date_there_is_nothing_to_advise_on(home):
    issued_interval(home, 2020, due=None)
    with pytest.raises(Unusable, match=r"has no recalibration date .*recalibration_agreed"):
        interval_advice("7", home)
