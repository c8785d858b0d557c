"""the tables as they were before the first release; what a column means stands in tables.py"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0013"  # the twelve before it were steps of development
down_revision = None

MOMENT = sa.DateTime(timezone=True)
NOTHING_BEFORE = "0" * 64
REFUSED = "the trail is append-only"
CHANNELS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)


def _texts(*names: str) -> list[sa.Column[Any]]:
    return [_column(name, sa.Text) for name in names]


metadata = sa.MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
    }
)

units = sa.Table(
    "units",
    metadata,
    _column("id", sa.Integer, primary_key=True),
    *_texts("manufacturer", "model", "serial"),
    sa.UniqueConstraint("manufacturer", "model", "serial"),
)

runs = sa.Table(
    "runs",
    metadata,
    _column("id", sa.Text, primary_key=True),
    _column("digest", sa.Text, unique=True),
    _column("recording_id", sa.Text, index=True),
    _column("unit", sa.Integer, sa.ForeignKey("units.id"), index=True),
    _column("standard", sa.Text),
    _column("taken_in_at", MOMENT),
    _column("seconds", sa.Float),
    _column("rows", sa.Integer),
    sa.Column("station", sa.Text, index=True),
    sa.Column("procedure", sa.Text),
    sa.Column("recorded_on", sa.Date, index=True),
)

equipment = sa.Table(
    "equipment",
    metadata,
    _column("run", sa.Text, sa.ForeignKey("runs.id"), primary_key=True),
    _column("document", sa.Text, primary_key=True),
    _column("name", sa.Text, primary_key=True),
    _column("serial", sa.Text, primary_key=True, index=True),
    _column("certificate", sa.Text, primary_key=True),
)

standards = sa.Table(
    "standards",
    metadata,
    _column("serial", sa.Text, primary_key=True),
    _column("certificate", sa.Text, primary_key=True),
    *_texts("name"),
    *(sa.Column(name, sa.Date) for name in ("calibrated_on", "valid_until")),
    _column("added_at", MOMENT),
    _column("document", sa.Text),
)

sources = sa.Table(
    "sources",
    metadata,
    _column("fingerprint", sa.Text, primary_key=True),
    _column("run", sa.Text, sa.ForeignKey("runs.id"), index=True),
    _column("path", sa.Text),
)

results = sa.Table(
    "results",
    metadata,
    _column("id", sa.Text, primary_key=True),
    _column("run", sa.Text, sa.ForeignKey("runs.id"), index=True),
    *_texts("method", "code_version"),
    _column("made_at", MOMENT),
    _column("document", sa.Text),
    sa.Column("supersedes", sa.Text, sa.ForeignKey("results.id"), unique=True),
    sa.Column("why", sa.Text),
)

elements = sa.Table(
    "elements",
    metadata,
    _column("result", sa.Text, sa.ForeignKey("results.id"), primary_key=True),
    _column("item", sa.Text, primary_key=True),
    _column("element", sa.Text, primary_key=True),
    *(sa.Column(name, sa.Float) for name in ("value", "u", "expanded")),
    _column("k", sa.Float),
    *_texts("unit"),
)

segments = sa.Table(
    "segments",
    metadata,
    _column("result", sa.Text, sa.ForeignKey("results.id"), primary_key=True),
    _column("number", sa.Integer, primary_key=True, autoincrement=False),
    *_texts("name", "kind", "origin"),
    *(sa.Column(name, sa.Text) for name in ("up", "axis")),
    *(_column(name, sa.Float) for name in ("t_start", "t_end")),
    sa.Column("rate_deg_s", sa.Float),
    *(_column(name, sa.Integer) for name in ("rows", "rows_left_out")),
    *(sa.Column(f"mean_{name}", sa.Float) for name in CHANNELS),
    *(sa.Column(f"deviation_{name}", sa.Float) for name in CHANNELS),
)

outcomes = sa.Table(
    "outcomes",
    metadata,
    _column("result", sa.Text, sa.ForeignKey("results.id"), primary_key=True),
    _column("run", sa.Text, sa.ForeignKey("runs.id")),
    *_texts("method", "terms"),
    _column("made_at", MOMENT),
    *_texts("verdict"),
    _column("missing", sa.Integer),
    sa.Index("ix_outcomes_run_made_at", "run", "made_at"),
)

users = sa.Table(
    "users",
    metadata,
    _column("name", sa.Text, primary_key=True),
    *_texts("role", "password"),
    _column("added_at", MOMENT),
)

sessions = sa.Table(
    "sessions",
    metadata,
    _column("id", sa.Text, primary_key=True),
    *_texts("name", "address"),
    _column("begun_at", MOMENT),
    sa.Column("ended_at", MOMENT),
)

signatures = sa.Table(
    "signatures",
    metadata,
    _column("nonce", sa.Text, primary_key=True),
    _column("taken_at", MOMENT),
    sa.Column("flow_run", sa.Text),
    sa.Column("done_at", MOMENT),
)

reprocessed = sa.Table(
    "reprocessed",
    metadata,
    _column("circumstances", sa.Text, primary_key=True),
    _column("made_again", sa.Text, primary_key=True),
    _column("run", sa.Text, sa.ForeignKey("runs.id"), index=True),
    sa.Column("before", sa.Text, sa.ForeignKey("results.id")),
    sa.Column("after", sa.Text, sa.ForeignKey("results.id")),
    sa.Column("fault", sa.Text),
    _column("seconds", sa.Float),
    _column("done_at", MOMENT),
)

series = sa.Table(
    "series",
    metadata,
    _column("pattern", sa.Text, primary_key=True),
    _column("last", sa.Integer),
    _column("before", sa.Integer),
)

certificates = sa.Table(
    "certificates",
    metadata,
    _column("number", sa.Text, primary_key=True),
    _column("result", sa.Text, sa.ForeignKey("results.id"), index=True),
    _column("run", sa.Text, sa.ForeignKey("runs.id"), index=True),
    _column("unit", sa.Integer, sa.ForeignKey("units.id"), index=True),
    *_texts("state", "verdict"),
    *(sa.Column(name, sa.Text) for name in ("purpose", "draft")),
    sa.Column("calibrated_on", sa.Date),
    _column("issued_on", sa.Date),
    sa.Column("due", sa.Date, index=True),
    _column("kept_at", MOMENT),
    *_texts("pdf", "pdf_sha256", "record", "record_sha256"),
    *(sa.Column(name, sa.Text) for name in ("dcc", "dcc_sha256", "evidence", "evidence_sha256")),
    sa.Column("supersedes", sa.Text, sa.ForeignKey("certificates.number"), unique=True),
    sa.Column("why", sa.Text),
    sa.Column("limits", sa.Integer),
)

decisions = sa.Table(
    "decisions",
    metadata,
    _column("certificate", sa.Text, sa.ForeignKey("certificates.number"), primary_key=True),
    _column("number", sa.Integer, primary_key=True, autoincrement=False),
    *_texts("item", "element", "applied_to"),
    *(sa.Column(name, sa.Float) for name in ("lower", "upper")),
    _column("verdict", sa.Text),
)

explained = sa.Table(
    "explained",
    metadata,
    _column("run", sa.Text, sa.ForeignKey("runs.id"), primary_key=True),
    _column("at", MOMENT),
    *_texts("code_version", "verdict"),
)

findings = sa.Table(
    "findings",
    metadata,
    _column("run", sa.Text, sa.ForeignKey("explained.run"), primary_key=True),
    _column("number", sa.Integer, primary_key=True, autoincrement=False),
    _column("effect", sa.Text, index=True),
    *(_column(name, sa.Float) for name in ("share", "delta_bic")),
    *_texts("document"),
)

reminders = sa.Table(
    "reminders",
    metadata,
    _column("certificate", sa.Text, sa.ForeignKey("certificates.number"), primary_key=True),
    _column("days", sa.Integer, primary_key=True, autoincrement=False),
    _column("channel", sa.Text, primary_key=True),
    _column("tries", sa.Integer),
    _column("next_try_at", MOMENT),
    sa.Column("sent_at", MOMENT),
    sa.Column("fault", sa.Text),
)

orders = sa.Table(
    "orders",
    metadata,
    _column("number", sa.Text, primary_key=True),
    *_texts("station", "units", "procedure"),
    sa.Column("client_order", sa.Text),
    *_texts("person"),
    _column("ordered_at", MOMENT),
    *_texts("state"),
    _column("is_interrupted", sa.Boolean),
    *(_column(name, sa.Integer) for name in ("attempts", "submissions")),
    *(sa.Column(name, sa.Text) for name in ("flow_run", "host")),
    sa.Column("process", sa.Integer),
    *(sa.Column(name, MOMENT) for name in ("began_at", "ended_at")),
    *_texts("runs", "certificates"),
    sa.Column("fault", sa.Text),
    sa.Index("ix_orders_state_station", "state", "station"),
)

trail = sa.Table(
    "trail",
    metadata,
    _column("number", sa.Integer, primary_key=True, autoincrement=False),
    _column("at", MOMENT),
    *_texts("person", "action"),
    _column("subject", sa.Text, index=True),
    *_texts("details", "previous_hash", "hash"),
)

trail_end = sa.Table(
    "trail_end",
    metadata,
    _column("id", sa.Integer, primary_key=True, autoincrement=False),
    _column("number", sa.Integer),
    *_texts("hash"),
)


def upgrade() -> None:
    metadata.create_all(op.get_bind())
    op.execute(trail_end.insert().values(id=1, number=0, hash=NOTHING_BEFORE))
    if op.get_bind().dialect.name == "sqlite":
        for change in ("UPDATE", "DELETE"):
            op.execute(
                f"CREATE TRIGGER trail_no_{change.lower()} BEFORE {change} ON trail "
                f"BEGIN SELECT RAISE(ABORT, '{REFUSED}'); END"
            )
    else:
        op.execute(
            "CREATE FUNCTION trail_is_append_only() RETURNS trigger LANGUAGE plpgsql AS "
            f"$$ BEGIN RAISE EXCEPTION '{REFUSED}'; END $$"
        )
        op.execute(
            "CREATE TRIGGER trail_unchanged BEFORE UPDATE OR DELETE OR TRUNCATE ON trail "
            "FOR EACH STATEMENT EXECUTE FUNCTION trail_is_append_only()"
        )
