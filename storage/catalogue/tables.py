"""The tables of the catalogue; storage/catalogue/migrations creates them."""

from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sql


class Utc(sql.TypeDecorator[datetime]):
    """A moment in UTC; SQLite, too, gives it back with its time zone."""

    impl = sql.DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: sql.Dialect) -> datetime | None:
        return None if value is None else value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: sql.Dialect) -> datetime | None:
        if value is None or value.tzinfo is not None:
            return value and value.astimezone(UTC)
        return value.replace(tzinfo=UTC)


CHANNELS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")  # rad/s, m/s²


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sql.Column[Any]:
    return sql.Column(name, kind, *more, nullable=False, **options)


def _texts(*names: str) -> list[sql.Column[Any]]:
    return [_column(name, sql.Text) for name in names]


metadata = sql.MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
    }
)

units = sql.Table(
    "units",
    metadata,
    _column("id", sql.Integer, primary_key=True),
    *_texts("manufacturer", "model", "serial"),
    sql.UniqueConstraint("manufacturer", "model", "serial"),
)

runs = sql.Table(
    "runs",
    metadata,
    _column("id", sql.Text, primary_key=True),
    _column("digest", sql.Text, unique=True),
    _column("recording_id", sql.Text, index=True),
    _column("unit", sql.Integer, sql.ForeignKey("units.id"), index=True),
    _column("standard", sql.Text),
    _column("imported_at", Utc),
    _column("seconds", sql.Float),
    _column("rows", sql.Integer),
    sql.Column("station", sql.Text, index=True),  # null: not yet read from the manifest
    sql.Column("procedure", sql.Text),
    sql.Column("recorded_on", sql.Date, index=True),
)

equipment = sql.Table(  # measurement standards: `document` is the manifest, or a certificate
    "equipment",
    metadata,
    _column("run", sql.Text, sql.ForeignKey("runs.id"), primary_key=True),
    _column("document", sql.Text, primary_key=True),
    _column("name", sql.Text, primary_key=True),
    _column("serial", sql.Text, primary_key=True, index=True),
    _column("certificate", sql.Text, primary_key=True),
)

standards = sql.Table(  # the laboratory's register; `document` is the whole record
    "standards",
    metadata,
    _column("serial", sql.Text, primary_key=True),
    _column("certificate", sql.Text, primary_key=True),
    *_texts("name"),
    *(sql.Column(name, sql.Date) for name in ("calibrated_on", "valid_until")),
    _column("added_at", Utc),
    _column("document", sql.Text),
)

sources = sql.Table(  # one content may come in from several files, as Parquet and as CSV
    "sources",
    metadata,
    _column("fingerprint", sql.Text, primary_key=True),
    _column("run", sql.Text, sql.ForeignKey("runs.id"), index=True),
    _column("path", sql.Text),
)

results = sql.Table(
    "results",
    metadata,
    _column("id", sql.Text, primary_key=True),
    _column("run", sql.Text, sql.ForeignKey("runs.id"), index=True),
    *_texts("method", "code_version"),
    _column("made_at", Utc),
    _column("document", sql.Text),
    sql.Column("supersedes", sql.Text, sql.ForeignKey("results.id"), unique=True),
    sql.Column("why", sql.Text),
)

elements = sql.Table(  # `expanded`: U, which SQLite does not tell from u
    "elements",
    metadata,
    _column("result", sql.Text, sql.ForeignKey("results.id"), primary_key=True),
    _column("item", sql.Text, primary_key=True),
    _column("element", sql.Text, primary_key=True),
    *(sql.Column(name, sql.Float) for name in ("value", "u", "expanded")),
    _column("k", sql.Float),
    *_texts("unit"),
)

segments = sql.Table(
    "segments",
    metadata,
    _column("result", sql.Text, sql.ForeignKey("results.id"), primary_key=True),
    _column("number", sql.Integer, primary_key=True, autoincrement=False),
    *_texts("name", "kind", "origin"),
    *(sql.Column(name, sql.Text) for name in ("up", "axis")),
    *(_column(name, sql.Float) for name in ("t_start", "t_end")),
    sql.Column("rate_deg_s", sql.Float),
    *(_column(name, sql.Integer) for name in ("rows", "rows_left_out")),
    *(sql.Column(f"mean_{name}", sql.Float) for name in CHANNELS),
    *(sql.Column(f"deviation_{name}", sql.Float) for name in CHANNELS),
)

outcomes = sql.Table(  # each result in brief: SQLite finds no row fast that holds a document
    "outcomes",
    metadata,
    _column("result", sql.Text, sql.ForeignKey("results.id"), primary_key=True),
    _column("run", sql.Text, sql.ForeignKey("runs.id")),
    *_texts("method", "terms"),  # those adopted beside the standard's, a space between two
    _column("made_at", Utc),
    *_texts("verdict"),  # on the run
    _column("missing", sql.Integer),  # elements without a value
    sql.Index("ix_outcomes_run_made_at", "run", "made_at"),
)

users = sql.Table(  # of the pages; `password`: its Argon2 hash
    "users",
    metadata,
    _column("name", sql.Text, primary_key=True),
    *_texts("role", "password"),
    _column("added_at", Utc),
)

sessions = sql.Table(  # of the pages; ended_at: the logout
    "sessions",
    metadata,
    _column("id", sql.Text, primary_key=True),
    *_texts("name", "address"),
    _column("begun_at", Utc),
    sql.Column("ended_at", Utc),
)

signatures = sql.Table(  # of orders, each used once; done_at: no flow run uses it any more
    "signatures",
    metadata,
    _column("nonce", sql.Text, primary_key=True),
    _column("taken_at", Utc),
    sql.Column("flow_run", sql.Text),
    sql.Column("done_at", Utc),
)

reprocessed = sql.Table(  # `made_again`: a result, or a run that had none
    "reprocessed",
    metadata,
    _column("circumstances", sql.Text, primary_key=True),
    _column("made_again", sql.Text, primary_key=True),
    _column("run", sql.Text, sql.ForeignKey("runs.id"), index=True),
    sql.Column("before", sql.Text, sql.ForeignKey("results.id")),
    sql.Column("after", sql.Text, sql.ForeignKey("results.id")),
    sql.Column("fault", sql.Text),
    _column("seconds", sql.Float),
    _column("done_at", Utc),
)

series = sql.Table(  # of certificate numbers, as `MIMU-2026-{serial:04d}`
    "series",
    metadata,
    _column("pattern", sql.Text, primary_key=True),
    _column("last", sql.Integer),
    _column("before", sql.Integer),  # the last that was given before there were drafts without
)

certificates = (
    sql.Table(  # `number`: of a draft its key; `draft`: the key under which it was issued
        "certificates",
        metadata,
        _column("number", sql.Text, primary_key=True),
        _column("result", sql.Text, sql.ForeignKey("results.id"), index=True),
        _column("run", sql.Text, sql.ForeignKey("runs.id"), index=True),
        _column("unit", sql.Integer, sql.ForeignKey("units.id"), index=True),
        *_texts("state", "verdict"),
        *(sql.Column(name, sql.Text) for name in ("purpose", "draft")),
        sql.Column("calibrated_on", sql.Date),
        _column("issued_on", sql.Date),
        sql.Column("due", sql.Date, index=True),
        _column("kept_at", Utc),
        *_texts("pdf", "pdf_sha256", "record", "record_sha256"),
        *(
            sql.Column(name, sql.Text)
            for name in ("dcc", "dcc_sha256", "evidence", "evidence_sha256")
        ),
        sql.Column("supersedes", sql.Text, sql.ForeignKey("certificates.number"), unique=True),
        sql.Column("why", sql.Text),
        sql.Column(
            "limits", sql.Integer
        ),  # rows of `decisions`; null: not yet read from the record
    )
)

decisions = sql.Table(  # each limit that a certificate decides on, as its record has it
    "decisions",
    metadata,
    _column("certificate", sql.Text, sql.ForeignKey("certificates.number"), primary_key=True),
    _column("number", sql.Integer, primary_key=True, autoincrement=False),
    *_texts("item", "element", "applied_to"),
    *(sql.Column(name, sql.Float) for name in ("lower", "upper")),
    _column("verdict", sql.Text),
)

explained = sql.Table(  # the last answer of `explain` to a run, in brief
    "explained",
    metadata,
    _column("run", sql.Text, sql.ForeignKey("runs.id"), primary_key=True),
    _column("at", Utc),
    *_texts("code_version", "verdict"),
)

findings = sql.Table(  # of that answer; `document`: `FindingInBrief`
    "findings",
    metadata,
    _column("run", sql.Text, sql.ForeignKey("explained.run"), primary_key=True),
    _column("number", sql.Integer, primary_key=True, autoincrement=False),
    _column("effect", sql.Text, index=True),
    *(_column(name, sql.Float) for name in ("share", "delta_bic")),
    *_texts("document"),
)

reminders = sql.Table(  # `days`: after the due date, negative before it; sent_at null: not yet
    "reminders",
    metadata,
    _column("certificate", sql.Text, sql.ForeignKey("certificates.number"), primary_key=True),
    _column("days", sql.Integer, primary_key=True, autoincrement=False),
    _column("channel", sql.Text, primary_key=True),
    _column("tries", sql.Integer),
    _column("next_try_at", Utc),
    sql.Column("sent_at", Utc),
    sql.Column("fault", sql.Text),
)

orders = sql.Table(  # of production; `units`, `client_order`, `runs`, `certificates`: JSON
    "orders",
    metadata,
    _column("number", sql.Text, primary_key=True),
    *_texts("station", "units", "procedure"),
    sql.Column("client_order", sql.Text),
    *_texts("person"),
    _column("ordered_at", Utc),
    *_texts("state"),
    _column("is_interrupted", sql.Boolean),
    *(_column(name, sql.Integer) for name in ("attempts", "submissions")),
    *(sql.Column(name, sql.Text) for name in ("flow_run", "host")),
    sql.Column("process", sql.Integer),
    *(sql.Column(name, Utc) for name in ("began_at", "ended_at")),
    *_texts("runs", "certificates"),
    sql.Column("fault", sql.Text),
    sql.Index("ix_orders_state_station", "state", "station"),
)

trail = sql.Table(  # who did what; the database refuses to change or delete a row
    "trail",
    metadata,
    _column("number", sql.Integer, primary_key=True, autoincrement=False),
    _column("at", Utc),
    *_texts("person", "action"),
    _column("subject", sql.Text, index=True),
    *_texts("details", "previous_hash", "hash"),
)

trail_end = sql.Table(  # one row
    "trail_end",
    metadata,
    _column("id", sql.Integer, primary_key=True, autoincrement=False),
    _column("number", sql.Integer),
    *_texts("hash"),
)
