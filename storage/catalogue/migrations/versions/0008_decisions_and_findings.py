"""what each certificate decides of each element, and what `explain` found in each run

Decisions of earlier certificates are filled in from their records when a question needs them.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    op.add_column("certificates", sa.Column("limits", sa.Integer()))
    op.create_table(
        "decisions",
        _column("certificate", sa.Text(), sa.ForeignKey("certificates.number"), primary_key=True),
        _column("number", sa.Integer(), primary_key=True, autoincrement=False),
        *(_column(name, sa.Text()) for name in ("item", "element", "applied_to")),
        *(sa.Column(name, sa.Float()) for name in ("lower", "upper")),
        _column("verdict", sa.Text()),
    )
    op.create_table(
        "explained",
        _column("run", sa.Text(), sa.ForeignKey("runs.id"), primary_key=True),
        _column("at", sa.DateTime(timezone=True)),
        *(_column(name, sa.Text()) for name in ("code_version", "verdict")),
    )
    op.create_table(
        "findings",
        _column("run", sa.Text(), sa.ForeignKey("explained.run"), primary_key=True),
        _column("number", sa.Integer(), primary_key=True, autoincrement=False),
        _column("effect", sa.Text()),
        *(_column(name, sa.Float()) for name in ("share", "delta_bic")),
        _column("document", sa.Text()),
    )
    op.create_index("ix_findings_effect", "findings", ["effect"])


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
