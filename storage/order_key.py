"""The key of the home that signs orders: whoever can read it can order in a person's name."""

import hashlib
import hmac
import json
from typing import Any

from schemas.signature import Signature
from storage import secret_files
from storage.home import Home

ORDER_KEY = "orders.key"


def signed(flow: str, order: dict[str, Any], unsigned: dict[str, Any], home: Home) -> Signature:
    """The signature of an order with the home's key, which is made where there is none yet.

    order: as JSON values, without a signature. unsigned: the fields of the signature but its mac.
    Raises Unusable where the key cannot be read, or can be by others.
    """
    draft = Signature(**unsigned, mac="0" * 64)
    key = secret_files.made(home.path / ORDER_KEY)
    return draft.model_copy(update={"mac": _mac(key, flow, order, draft)})


def is_signed(flow: str, order: dict[str, Any], signature: Signature, home: Home) -> bool:
    """Whether a signature is that of this order, for this flow, by the home's key.

    Raises Unusable where the key is missing, cannot be read, or can be by others.
    """
    key = secret_files.read(home.path / ORDER_KEY)
    return hmac.compare_digest(_mac(key, flow, order, signature), signature.mac)


def _mac(key: str, flow: str, order: dict[str, Any], signature: Signature) -> str:
    about = signature.model_dump(mode="json", exclude={"mac"})
    content = {"flow": flow, "order": order, "signature": about}
    text = json.dumps(content, ensure_ascii=True, sort_keys=True, separators=(",", ":"))
    return hmac.new(key.encode(), text.encode(), hashlib.sha256).hexdigest()
