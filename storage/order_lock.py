"""One order at a time at each station, and one process that takes them: locks like those of its
runs. The holder of the lock of a station's orders knows that any other order in progress was left
by a process that died.
"""

import fcntl
import hashlib
import hmac
import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from schemas.certificate import Signature
from storage import whole_files
from storage.home import Home
from storage.stations import lock_of
from storage.whole_files import writing_in_home


@contextmanager
def one_order_at(station: str, home: Home) -> Iterator[None]:
    """The orders of a station for the length of the block, once nobody else has them."""
    with _open(f"orders of {station}", home) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@contextmanager
def no_order_at(station: str, home: Home) -> Iterator[bool]:
    """Whether nobody has the orders of a station; then this process has, for the block."""
    with _if_free(f"orders of {station}", home) as is_free:
        yield is_free


@contextmanager
def only_worker_of(station: str, home: Home) -> Iterator[bool]:
    """Whether this process alone takes the orders of a station, for the length of the block."""
    with _if_free(f"worker of {station}", home) as is_alone:
        yield is_alone


@contextmanager
def _if_free(name: str, home: Home) -> Iterator[bool]:
    with _open(name, home) as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


@contextmanager
def _open(name: str, home: Home) -> Iterator[int]:
    file = lock_of(name, home)
    with writing_in_home(file):
        lock = file.open("a")
    with lock:
        yield lock.fileno()


# The key of the home that signs orders: whoever can read it can order in a person's name.

ORDER_KEY = "orders.key"


def signed(flow: str, order: dict[str, Any], unsigned: dict[str, Any], home: Home) -> Signature:
    """The signature of an order with the home's key, which is made where there is none yet.

    order: as JSON values, without a signature. unsigned: the fields of the signature but its mac.
    Raises Unusable where the key cannot be read, or can be by others.
    """
    draft = Signature(**unsigned, mac="0" * 64)
    key = whole_files.made(home.path / ORDER_KEY)
    return draft.model_copy(update={"mac": _mac(key, flow, order, draft)})


def is_signed(flow: str, order: dict[str, Any], signature: Signature, home: Home) -> bool:
    """Whether a signature is that of this order, for this flow, by the home's key.

    Raises Unusable where the key is missing, cannot be read, or can be by others.
    """
    key = whole_files.read(home.path / ORDER_KEY)
    return hmac.compare_digest(_mac(key, flow, order, signature), signature.mac)


def _mac(key: str, flow: str, order: dict[str, Any], signature: Signature) -> str:
    about = signature.model_dump(mode="json", exclude={"mac"})
    content = {"flow": flow, "order": order, "signature": about}
    text = json.dumps(content, ensure_ascii=True, sort_keys=True, separators=(",", ":"))
    return hmac.new(key.encode(), text.encode(), hashlib.sha256).hexdigest()
