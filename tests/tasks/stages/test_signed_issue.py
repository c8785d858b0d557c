"""What is issued is signed with the key that the laboratory's file in the home names."""

from datetime import UTC, datetime, timedelta

import pytest

from schemas.base import Unusable
from storage.home import Home
from tasks.certificate.verify import verify_file
from tasks.stages.issue import check, issue
from tests.drafts import draft
from tests.tasks.certificate.signing_keys import PASSPHRASE, Keys, keys

LABORATORY = """
[party]
name = "L"
name_zh = "L"
address = "A"
address_zh = "A"
[signing]
pkcs12 = "seal.p12"
"""


@pytest.fixture
def home(tmp_path, monkeypatch) -> Home:
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    monkeypatch.setenv("MIMUCAL_SIGNING_PASSPHRASE", PASSPHRASE)
    return Home(tmp_path / "home")


def checked(home: Home, seal: Keys) -> str:
    key = draft(home).certificate.number
    check(key, home, "Li")
    (home.path / "laboratory.toml").write_text(LABORATORY)
    (home.path / "seal.p12").write_bytes(seal.pkcs12())
    return key


def test_an_issued_certificate_is_signed(home):
    seal = keys(elliptic=True, now=datetime.now(UTC))
    done = issue(checked(home, seal), home, "Zhao")
    found = verify_file(done.pdf, [seal.authority_der()])
    assert found.faults == ()
    assert len(found.signatures) == 2
    assert b"seal.p12" not in done.record.read_bytes()


def test_an_expired_key_issues_nothing_and_no_number_is_lost(home):
    now = datetime.now(UTC)
    key = checked(home, keys(elliptic=True, days=30, now=now - timedelta(days=60)))
    with pytest.raises(Unusable, match="name a key with a valid"):
        issue(key, home, "Zhao")
    (home.path / "seal.p12").write_bytes(keys(elliptic=True, now=now).pkcs12())
    assert issue(key, home, "Zhao").certificate.number.endswith("-0001")
