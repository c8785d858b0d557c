"""the sessions of the pages, and the signatures of orders that were used"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"


def upgrade() -> None:
    op.create_table(
        "sessions",
        _column("id", sa.Text(), primary_key=True),
        *(_column(name, sa.Text()) for name in ("name", "address")),
        _column("begun_at", sa.DateTime(timezone=True)),
        sa.Column("ended_at", sa.DateTime(timezone=True)),
    )
    op.create_table(
        "signatures",
        _column("nonce", sa.Text(), primary_key=True),
        _column("taken_at", sa.DateTime(timezone=True)),
        sa.Column("flow_run", sa.Text()),
        sa.Column("done_at", sa.DateTime(timezone=True)),
    )


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
