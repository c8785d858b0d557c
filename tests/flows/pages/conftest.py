"""Passwords that cost a test nothing: Argon2 takes long on purpose."""

from collections.abc import Iterator

import pytest
from argon2 import PasswordHasher

from flows.pages import login


@pytest.fixture(scope="module", autouse=True)
def _passwords_at_once() -> Iterator[None]:
    hasher = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(login, "HASHER", hasher)
        patch.setattr(login, "DUMMY_HASH", hasher.hash(""))
        yield
