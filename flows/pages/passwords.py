"""Passwords: hashed with Argon2id, checked with a limit on failed attempts."""

from collections.abc import Iterator

from argon2 import PasswordHasher
from argon2.exceptions import Argon2Error, InvalidHashError
from limits import RateLimitItem, parse
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from schemas.access import User

HASHER = PasswordHasher()
LONGEST = 100  # characters of a user's name
# Failed attempts. One account from one address is locked soon; an account from any address, and an
# address of many people (a proxy, a laboratory behind one router), only after far more than
# ordinary typing errors.
PER_ACCOUNT_AND_ADDRESS = (parse("5/minute"), parse("30/hour"))
PER_ACCOUNT = (parse("20/minute"), parse("100/hour"))
PER_ADDRESS = (parse("60/minute"), parse("600/hour"))


def hashed(password: str) -> str:
    """The Argon2id hash of a password, with its salt and parameters."""
    return HASHER.hash(password)


DUMMY_HASH = hashed("")  # so that an unknown name takes as long as a known one


class Gate:
    """Checks a user's password, with a limit on failed attempts. Attempts are counted in the memory
    of the process that serves the pages. An account that does not exist is locked like any other.
    """

    def __init__(self) -> None:
        self._failed = MovingWindowRateLimiter(MemoryStorage())

    def is_locked(self, name: str, address: str) -> bool:
        """Whether so many tries failed that no further one is looked at."""
        return not all(self._failed.test(limit, *keys) for limit, keys in _limits(name, address))

    def check(self, user: User | None, password: str, name: str, address: str) -> bool:
        """Whether a password is the user's; a try that fails is counted."""
        try:
            right = (
                HASHER.verify(user.password if user else DUMMY_HASH, password) and user is not None
            )
        except (Argon2Error, InvalidHashError):
            right = False
        if not right:
            for limit, keys in _limits(name, address):
                self._failed.hit(limit, *keys)
        return right


def _limits(name: str, address: str) -> Iterator[tuple[RateLimitItem, tuple[str, ...]]]:
    """Each limit, and what it counts for. The beginning of a name is enough of it."""
    account = name[:LONGEST]
    for limits, keys in (
        (PER_ACCOUNT_AND_ADDRESS, ("both", account, address)),
        (PER_ACCOUNT, ("account", account)),
        (PER_ADDRESS, ("address", address)),
    ):
        for limit in limits:
            yield limit, keys
