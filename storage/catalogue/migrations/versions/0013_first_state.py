"""the tables as they were before the first release; what a column means stands in tables.py"""

from alembic import op

from storage.catalogue.tables import catalogue, table

revision = "0013"  # the twelve before it were steps of development
down_revision = None

NOTHING_BEFORE = "0" * 64
REFUSED = "the trail is append-only"
TABLES = {
    "units": """
    id: integer drawn
    manufacturer, model, serial: text
    unique: manufacturer, model, serial
""",
    "runs": """
    id: text key
    digest: text unique
    recording_id: text index
    unit: integer index -> units.id
    standard: text
    taken_in_at: moment
    seconds: float
    rows: integer
    station: text? index
    procedure: text?
    recorded_on: date? index
""",
    "equipment": """
    run: text key -> runs.id
    document, name: text key
    serial: text key index
    certificate: text key
""",
    "standards": """
    serial, certificate: text key
    name: text
    calibrated_on, valid_until: date?
    added_at: moment
    document: text
""",
    "sources": """
    fingerprint: text key
    run: text index -> runs.id
    path: text
""",
    "results": """
    id: text key
    run: text index -> runs.id
    method, code_version: text
    made_at: moment
    document: text
    supersedes: text? unique -> results.id
    why: text?
""",
    "elements": """
    result: text key -> results.id
    item, element: text key
    value, u, expanded: float?
    k: float
    unit: text
""",
    "segments": """
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
""",
    "outcomes": """
    result: text key -> results.id
    run: text -> runs.id
    method, terms: text
    made_at: moment
    verdict: text
    missing: integer
    index: run, made_at
""",
    "users": """
    name: text key
    role, password: text
    added_at: moment
""",
    "sessions": """
    id: text key
    name, address: text
    begun_at: moment
    ended_at: moment?
""",
    "signatures": """
    nonce: text key
    taken_at: moment
    flow_run: text?
    done_at: moment?
""",
    "reprocessed": """
    circumstances, made_again: text key
    run: text index -> runs.id
    before, after: text? -> results.id
    fault: text?
    seconds: float
    done_at: moment
""",
    "series": """
    pattern: text key
    last, before: integer
""",
    "certificates": """
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
""",
    "decisions": """
    certificate: text key -> certificates.number
    number: integer key
    item, element, applied_to: text
    lower, upper: float?
    verdict: text
""",
    "explained": """
    run: text key -> runs.id
    at: moment
    code_version, verdict: text
""",
    "findings": """
    run: text key -> explained.run
    number: integer key
    effect: text index
    share, delta_bic: float
    document: text
""",
    "reminders": """
    certificate: text key -> certificates.number
    days: integer key
    channel: text key
    tries: integer
    next_try_at: moment
    sent_at: moment?
    fault: text?
""",
    "orders": """
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
""",
    "trail": """
    number: integer key
    at: moment
    person, action: text
    subject: text index
    details, previous_hash, hash: text
""",
    "trail_end": """
    id: integer key
    number: integer
    hash: text
""",
}  # fmt: skip


def upgrade() -> None:
    metadata = catalogue()
    made = {name: table(metadata, name, columns) for name, columns in TABLES.items()}
    metadata.create_all(op.get_bind())
    op.execute(made["trail_end"].insert().values(id=1, number=0, hash=NOTHING_BEFORE))
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
