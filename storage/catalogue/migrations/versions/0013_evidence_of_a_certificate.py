"""the evidence file beside a certificate"""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"


def upgrade() -> None:
    for name in ("evidence", "evidence_sha256"):
        op.add_column("certificates", sa.Column(name, sa.Text()))
