"""release 0.2.0: when a run was imported has the name of what happened"""

from alembic import op

revision = "0014"
down_revision = "0013"


def upgrade() -> None:
    op.alter_column("runs", "taken_in_at", new_column_name="imported_at")
