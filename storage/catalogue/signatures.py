"""The signatures of orders that were carried out: each is taken once."""

from datetime import UTC, datetime

import sqlalchemy as sql

from schemas.signature import Signature
from storage.catalogue import database, tables, trail
from storage.home import Home


def take(signature: Signature, flow: str, subject: str, flow_run: str | None, home: Home) -> bool:
    """Uses a signature, with an entry in the trail; returns whether it was still unused.

    flow_run: the same flow run may take it again while it has not come to an end, as when Prefect
    tries it again after a crash.
    """
    now, table = datetime.now(UTC), tables.signatures
    taken = {"nonce": signature.nonce, "taken_at": now, "flow_run": flow_run}
    with database.changing(home) as connection:
        if database.add_new(connection, table, **taken):
            trail.add(
                connection, signature.person, f"sign {flow}", subject, at=now,
                signed_at=signature.signed_at.astimezone(UTC).isoformat(),
                signed_on=signature.signed_on, nonce=signature.nonce,
            )  # fmt: skip
            return True
        again = sql.select(table.c.flow_run).where(
            table.c.nonce == signature.nonce, table.c.done_at.is_(None)
        )
        return flow_run is not None and connection.scalar(again) == flow_run


def finish(signature: Signature, home: Home) -> None:
    """No flow run takes it any more: its order was carried out, or refused for good."""
    table = tables.signatures
    done = sql.update(table).where(table.c.nonce == signature.nonce)
    with database.changing(home) as connection:
        connection.execute(done.values(done_at=datetime.now(UTC)))
