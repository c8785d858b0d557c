"""first tables

Constraints and indexes have the names of the convention in storage/catalogue/tables.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    op.create_table(
        "numbers",
        _column("prefix", sa.Text(), primary_key=True),
        _column("year", sa.Integer(), primary_key=True, autoincrement=False),
        _column("last", sa.Integer()),
    )
    op.create_table(
        "units",
        _column("id", sa.Integer(), primary_key=True),
        *_texts("manufacturer", "model", "serial"),
        sa.UniqueConstraint("manufacturer", "model", "serial"),
    )
    op.create_table(
        "runs",
        _column("id", sa.Text(), primary_key=True),
        _column("digest", sa.Text(), unique=True),
        _column("recording_id", sa.Text(), index=True),
        _column("unit", sa.Integer(), sa.ForeignKey("units.id"), index=True),
        _column("standard", sa.Text()),
        _column("taken_in_at", sa.DateTime(timezone=True)),
        _column("seconds", sa.Float()),
        _column("rows", sa.Integer()),
    )
    op.create_table(
        "results",
        _column("id", sa.Text(), primary_key=True),
        _column("run", sa.Text(), sa.ForeignKey("runs.id"), index=True),
        *_texts("method", "code_version"),
        _column("made_at", sa.DateTime(timezone=True)),
        _column("document", sa.Text()),
        sa.Column("supersedes", sa.Text(), sa.ForeignKey("results.id"), unique=True),
        sa.Column("why", sa.Text()),
    )
    op.create_table(
        "sources",
        _column("fingerprint", sa.Text(), primary_key=True),
        _column("run", sa.Text(), sa.ForeignKey("runs.id"), index=True),
        _column("path", sa.Text()),
    )
    op.create_table(
        "certificates",
        _column("number", sa.Text(), primary_key=True),
        _column("result", sa.Text(), sa.ForeignKey("results.id"), index=True),
        _column("run", sa.Text(), sa.ForeignKey("runs.id"), index=True),
        _column("unit", sa.Integer(), sa.ForeignKey("units.id"), index=True),
        *_texts("state", "verdict"),
        _column("calibrated_on", sa.Date()),
        _column("issued_on", sa.Date()),
        _column("due", sa.Date(), index=True),
        _column("kept_at", sa.DateTime(timezone=True)),
        *_texts("pdf", "pdf_sha256", "record", "record_sha256"),
        sa.Column("supersedes", sa.Text(), sa.ForeignKey("certificates.number"), unique=True),
        sa.Column("why", sa.Text()),
    )
    op.create_table(
        "reminders",
        _column("certificate", sa.Text(), sa.ForeignKey("certificates.number"), primary_key=True),
        _column("channel", sa.Text(), primary_key=True),
        _column("sent_at", sa.DateTime(timezone=True)),
    )


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)


def _texts(*names: str) -> list[sa.Column[Any]]:
    return [_column(name, sa.Text()) for name in names]
