"""The tables of the catalogue; storage/catalogue/migrations creates them."""

from datetime import UTC, datetime

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
KINDS = {"text": sql.Text, "integer": sql.Integer, "float": sql.Float, "boolean": sql.Boolean,
         "date": sql.Date, "moment": Utc}  # fmt: skip


def catalogue() -> sql.MetaData:
    """Tables whose constraints are named by the same rule in every database."""
    named = {"pk": "pk_%(table_name)s", "fk": "fk_%(table_name)s_%(column_0_N_name)s"}
    of_columns = {kind: f"{kind}_%(table_name)s_%(column_0_N_name)s" for kind in ("uq", "ix")}
    return sql.MetaData(naming_convention=named | of_columns)


def table(metadata: sql.MetaData, name: str, written: str) -> sql.Table:
    """A table from its columns as they are written, those that are alike on one line.

    “NAME, NAME: KIND” with “?” where it may be null; then “key” (of the primary key), “drawn” (a
    key that the database gives), “unique”, “index” or “-> TABLE.COLUMN”. Of several columns
    together: “unique: NAME, NAME” and “index: NAME, NAME”.
    """
    parts: list[sql.Column[object] | sql.UniqueConstraint | sql.Index] = []
    for line in filter(None, map(str.strip, written.splitlines())):
        first, rest = line.split(": ")
        about, _, target = rest.partition(" -> ")
        if first == "unique":
            parts.append(sql.UniqueConstraint(*rest.split(", ")))
            continue
        if first == "index":
            parts.append(sql.Index(None, *rest.split(", ")))
            continue
        kind, *flags = about.split()
        parts += [
            sql.Column(
                each, KINDS[kind.rstrip("?")], *([sql.ForeignKey(target)] if target else []),
                nullable=kind.endswith("?"), primary_key="key" in flags or "drawn" in flags,
                autoincrement="drawn" in flags, unique="unique" in flags or None,
                index="index" in flags or None,
            )
            for each in first.split(", ")
        ]  # fmt: skip
    return sql.Table(name, metadata, *parts)


metadata = catalogue()

units = table(metadata, "units", """
    id: integer drawn
    manufacturer, model, serial: text
    unique: manufacturer, model, serial
""")  # fmt: skip

# `station` null: not yet read from the manifest
runs = table(metadata, "runs", """
    id: text key
    digest: text unique
    recording_id: text index
    unit: integer index -> units.id
    standard: text
    imported_at: moment
    seconds: float
    rows: integer
    station: text? index
    procedure: text?
    recorded_on: date? index
""")  # fmt: skip

# measurement standards: `document` is the manifest, or a certificate
equipment = table(metadata, "equipment", """
    run: text key -> runs.id
    document, name: text key
    serial: text key index
    certificate: text key
""")  # fmt: skip

# the laboratory's register; `document` is the whole record
standards = table(metadata, "standards", """
    serial, certificate: text key
    name: text
    calibrated_on, valid_until: date?
    added_at: moment
    document: text
""")  # fmt: skip

# one content may come in from several files, as Parquet and as CSV
sources = table(metadata, "sources", """
    fingerprint: text key
    run: text index -> runs.id
    path: text
""")  # fmt: skip

results = table(metadata, "results", """
    id: text key
    run: text index -> runs.id
    method, code_version: text
    made_at: moment
    document: text
    supersedes: text? unique -> results.id
    why: text?
""")  # fmt: skip

# `expanded`: U, which SQLite does not tell from u
elements = table(metadata, "elements", """
    result: text key -> results.id
    item, element: text key
    value, u, expanded: float?
    k: float
    unit: text
""")  # fmt: skip

segments = table(metadata, "segments", """
    result: text key -> results.id
    number: integer key
    name, kind, origin: text
    up, axis: text?
    t_start, t_end: float
    rate_deg_s: float?
    rows, rows_left_out: integer
    mean_gyro_x, mean_gyro_y, mean_gyro_z, mean_accel_x, mean_accel_y, mean_accel_z: float?
    deviation_gyro_x, deviation_gyro_y, deviation_gyro_z: float?
    deviation_accel_x, deviation_accel_y, deviation_accel_z: float?
""")  # fmt: skip

# each result in brief: SQLite finds no row fast that holds a document; `terms`: those
# adopted beside the standard's, a space between two; `verdict`: on the run; `missing`: elements
# without a value
outcomes = table(metadata, "outcomes", """
    result: text key -> results.id
    run: text -> runs.id
    method, terms: text
    made_at: moment
    verdict: text
    missing: integer
    index: run, made_at
""")  # fmt: skip

# of the pages; `password`: its Argon2 hash
users = table(metadata, "users", """
    name: text key
    role, password: text
    added_at: moment
""")  # fmt: skip

# of the pages; ended_at: the logout
sessions = table(metadata, "sessions", """
    id: text key
    name, address: text
    begun_at: moment
    ended_at: moment?
""")  # fmt: skip

# of orders, each used once; done_at: no flow run uses it any more
signatures = table(metadata, "signatures", """
    nonce: text key
    taken_at: moment
    flow_run: text?
    done_at: moment?
""")  # fmt: skip

# `made_again`: a result, or a run that had none
reprocessed = table(metadata, "reprocessed", """
    circumstances, made_again: text key
    run: text index -> runs.id
    before, after: text? -> results.id
    fault: text?
    seconds: float
    done_at: moment
""")  # fmt: skip

# of certificate numbers, as `MIMU-2026-{serial:04d}`; `before`: the last that was given before
# there were drafts without
series = table(metadata, "series", """
    pattern: text key
    last, before: integer
""")  # fmt: skip

# `number`: of a draft its key; `draft`: the key under which it was issued; `limits`: rows
# of `decisions`, null where not yet read from the record
certificates = table(metadata, "certificates", """
    number: text key
    result: text index -> results.id
    run: text index -> runs.id
    unit: integer index -> units.id
    state, verdict: text
    purpose, draft: text?
    calibrated_on: date?
    issued_on: date
    due: date? index
    kept_at: moment
    pdf, pdf_sha256, record, record_sha256: text
    dcc, dcc_sha256, evidence, evidence_sha256: text?
    supersedes: text? unique -> certificates.number
    why: text?
    limits: integer?
""")  # fmt: skip

# each limit that a certificate decides on, as its record has it
decisions = table(metadata, "decisions", """
    certificate: text key -> certificates.number
    number: integer key
    item, element, applied_to: text
    lower, upper: float?
    verdict: text
""")  # fmt: skip

# the last answer of `explain` to a run, in brief
explained = table(metadata, "explained", """
    run: text key -> runs.id
    at: moment
    code_version, verdict: text
""")  # fmt: skip

# of that answer; `document`: `FindingInBrief`
findings = table(metadata, "findings", """
    run: text key -> explained.run
    number: integer key
    effect: text index
    share, delta_bic: float
    document: text
""")  # fmt: skip

# `days`: after the due date, negative before it; sent_at null: not yet
reminders = table(metadata, "reminders", """
    certificate: text key -> certificates.number
    days: integer key
    channel: text key
    tries: integer
    next_try_at: moment
    sent_at: moment?
    fault: text?
""")  # fmt: skip

# of production; `units`, `client_order`, `runs`, `certificates`: JSON
orders = table(metadata, "orders", """
    number: text key
    station, units, procedure: text
    client_order: text?
    person: text
    ordered_at: moment
    state: text
    is_interrupted: boolean
    attempts, submissions: integer
    flow_run, host: text?
    process: integer?
    began_at, ended_at: moment?
    runs, certificates: text
    fault: text?
    index: state, station
""")  # fmt: skip

# who did what; the database refuses to change or delete a row
trail = table(metadata, "trail", """
    number: integer key
    at: moment
    person, action: text
    subject: text index
    details, previous_hash, hash: text
""")  # fmt: skip

# one row
trail_end = table(metadata, "trail_end", """
    id: integer key
    number: integer
    hash: text
""")  # fmt: skip
