"""the day of a recording that states only `acquired_at`, the moment of its first row

Manifests of runs without a day are read again when a question needs them: a run whose station is
not known yet is one whose manifest was not read.
"""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    runs = sa.table("runs", sa.column("station"), sa.column("recorded_on"))
    op.execute(sa.update(runs).where(runs.c.recorded_on.is_(None)).values(station=None))
