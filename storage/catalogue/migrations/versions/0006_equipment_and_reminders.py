"""the register of measurement standards, and each reminder with its tries

No earlier version sent a reminder, so that the table of them is empty.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    op.create_table(
        "standards",
        *(_column(name, sa.Text(), primary_key=True) for name in ("serial", "certificate")),
        _column("name", sa.Text()),
        *(sa.Column(name, sa.Date(), nullable=True) for name in ("calibrated_on", "valid_until")),
        _column("added_at", sa.DateTime(timezone=True)),
        _column("document", sa.Text()),
    )
    op.drop_table("reminders")
    op.create_table(
        "reminders",
        _column("certificate", sa.Text(), sa.ForeignKey("certificates.number"), primary_key=True),
        _column("days", sa.Integer(), primary_key=True, autoincrement=False),
        _column("channel", sa.Text(), primary_key=True),
        _column("tries", sa.Integer()),
        _column("next_try_at", sa.DateTime(timezone=True)),
        sa.Column("sent_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("fault", sa.Text(), nullable=True),
    )


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
