"""production orders: the queue of each station, and what became of every order"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    op.create_table(
        "orders",
        _column("number", sa.Text(), primary_key=True),
        _column("station", sa.Text()),
        *(_column(name, sa.Text()) for name in ("units", "procedure")),
        sa.Column("client_order", sa.Text()),
        _column("person", sa.Text()),
        _column("ordered_at", sa.DateTime(timezone=True)),
        _column("state", sa.Text()),
        _column("is_interrupted", sa.Boolean()),
        *(_column(name, sa.Integer()) for name in ("attempts", "submissions")),
        *(sa.Column(name, sa.Text()) for name in ("flow_run", "host")),
        sa.Column("process", sa.Integer()),
        *(sa.Column(name, sa.DateTime(timezone=True)) for name in ("began_at", "ended_at")),
        *(_column(name, sa.Text()) for name in ("runs", "certificates")),
        sa.Column("fault", sa.Text()),
    )
    op.create_index("ix_orders_state_station", "orders", ["state", "station"])


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
