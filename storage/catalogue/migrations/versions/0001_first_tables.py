"""first tables"""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    op.create_table(
        "numbers",
        sa.Column("prefix", sa.Text(), nullable=False),
        sa.Column("year", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("last", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("prefix", "year", name="pk_numbers"),
    )
    op.create_table(
        "units",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("manufacturer", sa.Text(), nullable=False),
        sa.Column("model", sa.Text(), nullable=False),
        sa.Column("serial", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_units"),
        sa.UniqueConstraint(
            "manufacturer", "model", "serial", name="uq_units_manufacturer_model_serial"
        ),
    )
    op.create_table(
        "runs",
        sa.Column("id", sa.Text(), nullable=False),
        sa.Column("digest", sa.Text(), nullable=False),
        sa.Column("recording_id", sa.Text(), nullable=False),
        sa.Column("unit", sa.Integer(), nullable=False),
        sa.Column("standard", sa.Text(), nullable=False),
        sa.Column("taken_in_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("seconds", sa.Float(), nullable=False),
        sa.Column("rows", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["unit"], ["units.id"], name="fk_runs_unit"),
        sa.PrimaryKeyConstraint("id", name="pk_runs"),
        sa.UniqueConstraint("digest", name="uq_runs_digest"),
    )
    op.create_index("ix_runs_recording_id", "runs", ["recording_id"], unique=False)
    op.create_index("ix_runs_unit", "runs", ["unit"], unique=False)
    op.create_table(
        "results",
        sa.Column("id", sa.Text(), nullable=False),
        sa.Column("run", sa.Text(), nullable=False),
        sa.Column("method", sa.Text(), nullable=False),
        sa.Column("code_version", sa.Text(), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("document", sa.Text(), nullable=False),
        sa.Column("supersedes", sa.Text(), nullable=True),
        sa.Column("why", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(["run"], ["runs.id"], name="fk_results_run"),
        sa.ForeignKeyConstraint(["supersedes"], ["results.id"], name="fk_results_supersedes"),
        sa.PrimaryKeyConstraint("id", name="pk_results"),
        sa.UniqueConstraint("supersedes", name="uq_results_supersedes"),
    )
    op.create_index("ix_results_run", "results", ["run"], unique=False)
    op.create_table(
        "sources",
        sa.Column("fingerprint", sa.Text(), nullable=False),
        sa.Column("run", sa.Text(), nullable=False),
        sa.Column("path", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["run"], ["runs.id"], name="fk_sources_run"),
        sa.PrimaryKeyConstraint("fingerprint", name="pk_sources"),
    )
    op.create_index("ix_sources_run", "sources", ["run"], unique=False)
    op.create_table(
        "certificates",
        sa.Column("number", sa.Text(), nullable=False),
        sa.Column("result", sa.Text(), nullable=False),
        sa.Column("run", sa.Text(), nullable=False),
        sa.Column("unit", sa.Integer(), nullable=False),
        sa.Column("state", sa.Text(), nullable=False),
        sa.Column("verdict", sa.Text(), nullable=False),
        sa.Column("calibrated_on", sa.Date(), nullable=False),
        sa.Column("issued_on", sa.Date(), nullable=False),
        sa.Column("due", sa.Date(), nullable=False),
        sa.Column("kept_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("pdf", sa.Text(), nullable=False),
        sa.Column("pdf_sha256", sa.Text(), nullable=False),
        sa.Column("record", sa.Text(), nullable=False),
        sa.Column("record_sha256", sa.Text(), nullable=False),
        sa.Column("supersedes", sa.Text(), nullable=True),
        sa.Column("why", sa.Text(), nullable=True),
        sa.ForeignKeyConstraint(["result"], ["results.id"], name="fk_certificates_result"),
        sa.ForeignKeyConstraint(["run"], ["runs.id"], name="fk_certificates_run"),
        sa.ForeignKeyConstraint(
            ["supersedes"], ["certificates.number"], name="fk_certificates_supersedes"
        ),
        sa.ForeignKeyConstraint(["unit"], ["units.id"], name="fk_certificates_unit"),
        sa.PrimaryKeyConstraint("number", name="pk_certificates"),
        sa.UniqueConstraint("supersedes", name="uq_certificates_supersedes"),
    )
    op.create_index("ix_certificates_due", "certificates", ["due"], unique=False)
    op.create_index("ix_certificates_result", "certificates", ["result"], unique=False)
    op.create_index("ix_certificates_run", "certificates", ["run"], unique=False)
    op.create_index("ix_certificates_unit", "certificates", ["unit"], unique=False)
    op.create_table(
        "reminders",
        sa.Column("certificate", sa.Text(), nullable=False),
        sa.Column("channel", sa.Text(), nullable=False),
        sa.Column("sent_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["certificate"], ["certificates.number"], name="fk_reminders_certificate"
        ),
        sa.PrimaryKeyConstraint("certificate", "channel", name="pk_reminders"),
    )
