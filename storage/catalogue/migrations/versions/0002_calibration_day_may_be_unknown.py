"""the day of calibration may be unknown

A column of its own, because SQLite cannot take a NOT NULL back.
"""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    op.add_column("certificates", sa.Column("day", sa.Date(), nullable=True))
    op.execute("UPDATE certificates SET day = calibrated_on")
    op.drop_column("certificates", "calibrated_on")
    op.alter_column("certificates", "day", new_column_name="calibrated_on")
