"""Passwords: hashed with Argon2id, checked with a limit on failed attempts."""

from argon2 import PasswordHasher
from argon2.exceptions import Argon2Error, InvalidHashError
from limits import parse
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from schemas.access import User

HASHER = PasswordHasher()
TRIES = (parse("5/minute"), parse("30/hour"))  # that fail, for a name as well as from an address


def hashed(password: str) -> str:
    """The Argon2id hash of a password, with its salt and parameters."""
    return HASHER.hash(password)


NOBODY = hashed("")  # an unknown name takes as long as a known one


class Gate:
    """Whether somebody is who they say, with a limit on the tries that fail.

    The tries are counted in the memory of the process that serves the pages.
    """

    def __init__(self) -> None:
        self._failed = MovingWindowRateLimiter(MemoryStorage())

    def is_shut(self, name: str, address: str) -> bool:
        """Whether so many tries failed that no further one is looked at."""
        return any(
            not self._failed.test(limit, key) for limit in TRIES for key in _keys(name, address)
        )

    def check(self, user: User | None, password: str, name: str, address: str) -> bool:
        """Whether a password is the user's; a try that fails is counted."""
        try:
            right = HASHER.verify(user.password if user else NOBODY, password) and user is not None
        except (Argon2Error, InvalidHashError):
            right = False
        if not right:
            for limit in TRIES:
                for key in _keys(name, address):
                    self._failed.hit(limit, key)
        return right


def _keys(name: str, address: str) -> tuple[str, str]:
    return f"name {name}", f"address {address}"
