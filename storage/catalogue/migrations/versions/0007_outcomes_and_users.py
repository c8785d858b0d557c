"""each result in brief, and the users of the pages

Outcomes of earlier results are filled in from their documents when a question needs them.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    op.create_table(
        "outcomes",
        _column("result", sa.Text(), sa.ForeignKey("results.id"), primary_key=True),
        _column("run", sa.Text(), sa.ForeignKey("runs.id")),
        _column("method", sa.Text()),
        _column("made_at", sa.DateTime(timezone=True)),
        _column("verdict", sa.Text()),
        _column("missing", sa.Integer()),
    )
    op.create_index("ix_outcomes_run_made_at", "outcomes", ["run", "made_at"])
    op.create_table(
        "users",
        _column("name", sa.Text(), primary_key=True),
        *(_column(name, sa.Text()) for name in ("role", "password")),
        _column("added_at", sa.DateTime(timezone=True)),
    )


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
