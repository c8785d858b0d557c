"""Secrets in files: made once, and read only where nobody else can read them."""

from pathlib import Path

import pytest

from schemas.base import Unusable
from storage import secret_files


def test_a_secret_is_made_once_for_its_owner_alone(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)  # a home that everybody may read does not share it
    path = tmp_path / "orders.key"
    made = secret_files.made(path)
    assert secret_files.made(path) == secret_files.read(path) == made
    assert path.stat().st_mode & 0o777 == 0o600
    assert [each.name for each in tmp_path.iterdir()] == ["orders.key"]


@pytest.mark.parametrize("rights", [0o640, 0o604, 0o660])
def test_a_secret_that_others_may_read_is_none(tmp_path: Path, rights: int) -> None:
    path = tmp_path / "orders.key"
    secret_files.made(path)
    path.chmod(rights)
    with pytest.raises(Unusable, match="chmod 600"):
        secret_files.made(path)


def test_a_link_in_the_place_of_a_secret_is_refused(tmp_path: Path) -> None:
    secret_files.made(tmp_path / "known.key")
    (tmp_path / "orders.key").symlink_to(tmp_path / "known.key")
    with pytest.raises(Unusable, match="a file of its own"):
        secret_files.made(tmp_path / "orders.key")


def test_what_is_too_short_to_be_a_secret_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "proxy.secret"
    path.write_text("secret\n")
    path.chmod(0o600)
    with pytest.raises(Unusable, match="6 characters"):
        secret_files.read(path)


def test_a_secret_that_is_missing_is_not_made_by_reading(tmp_path: Path) -> None:
    with pytest.raises(Unusable, match="cannot be read"):
        secret_files.read(tmp_path / "orders.key")
    assert not list(tmp_path.iterdir())
