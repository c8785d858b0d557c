"""where and with what a run was recorded, and what was re-processed

The new columns of a run are filled in from its manifest when a question needs them.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    op.add_column("runs", sa.Column("station", sa.Text(), nullable=True))
    op.add_column("runs", sa.Column("procedure", sa.Text(), nullable=True))
    op.add_column("runs", sa.Column("recorded_on", sa.Date(), nullable=True))
    op.create_index("ix_runs_station", "runs", ["station"])
    op.create_index("ix_runs_recorded_on", "runs", ["recorded_on"])
    op.create_table(
        "equipment",
        _column("run", sa.Text(), sa.ForeignKey("runs.id"), primary_key=True),
        *(
            _column(name, sa.Text(), primary_key=True)
            for name in ("document", "name", "serial", "certificate")
        ),
    )
    op.create_index("ix_equipment_serial", "equipment", ["serial"])
    op.create_table(
        "reprocessed",
        _column("circumstances", sa.Text(), primary_key=True),
        _column("made_again", sa.Text(), primary_key=True),
        _column("run", sa.Text(), sa.ForeignKey("runs.id"), index=True),
        sa.Column("before", sa.Text(), sa.ForeignKey("results.id"), nullable=True),
        sa.Column("after", sa.Text(), sa.ForeignKey("results.id"), nullable=True),
        sa.Column("fault", sa.Text(), nullable=True),
        _column("seconds", sa.Float()),
        _column("done_at", sa.DateTime(timezone=True)),
    )


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
