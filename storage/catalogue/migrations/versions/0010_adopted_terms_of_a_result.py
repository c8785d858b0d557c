"""the terms that each result adopts beside the standard's

Outcomes are filled in again from the documents when a question needs them.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"


def upgrade() -> None:
    op.drop_table("outcomes")
    op.create_table(
        "outcomes",
        _column("result", sa.Text(), sa.ForeignKey("results.id"), primary_key=True),
        _column("run", sa.Text(), sa.ForeignKey("runs.id")),
        *(_column(name, sa.Text()) for name in ("method", "terms")),
        _column("made_at", sa.DateTime(timezone=True)),
        _column("verdict", sa.Text()),
        _column("missing", sa.Integer()),
    )
    op.create_index("ix_outcomes_run_made_at", "outcomes", ["run", "made_at"])


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
