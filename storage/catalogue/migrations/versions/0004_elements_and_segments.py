"""the elements and the segments of each result, as rows

Those of earlier results are filled in from their documents when a question needs them.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"

CHANNELS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def upgrade() -> None:
    op.create_table(
        "elements",
        _key("result", sa.ForeignKey("results.id")),
        _key("item"),
        _key("element"),
        *(sa.Column(name, sa.Float(), nullable=True) for name in ("value", "u", "expanded")),
        sa.Column("k", sa.Float(), nullable=False),
        sa.Column("unit", sa.Text(), nullable=False),
    )
    op.create_table(
        "segments",
        _key("result", sa.ForeignKey("results.id")),
        sa.Column("number", sa.Integer(), primary_key=True, nullable=False, autoincrement=False),
        *(sa.Column(name, sa.Text(), nullable=False) for name in ("name", "kind", "origin")),
        *(sa.Column(name, sa.Text(), nullable=True) for name in ("up", "axis")),
        *(sa.Column(name, sa.Float(), nullable=False) for name in ("t_start", "t_end")),
        sa.Column("rate_deg_s", sa.Float(), nullable=True),
        *(sa.Column(name, sa.Integer(), nullable=False) for name in ("rows", "rows_left_out")),
        *(
            sa.Column(f"{what}_{channel}", sa.Float(), nullable=True)
            for what in ("mean", "deviation")
            for channel in CHANNELS
        ),
    )


def _key(name: str, *more: Any) -> sa.Column[Any]:
    return sa.Column(name, sa.Text(), *more, primary_key=True, nullable=False)
