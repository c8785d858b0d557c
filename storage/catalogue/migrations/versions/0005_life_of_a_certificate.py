"""drafts without a number, series of numbers without gaps, the DCC, and the trail

`before`: the last number that an earlier version gave when it made a draft; there may be gaps up to
it. `due` may be unknown, in a column of its own because SQLite cannot take a NOT NULL back.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"

NOTHING_BEFORE = "0" * 64
REFUSED = "the trail is append-only"


def upgrade() -> None:
    _series()
    _certificates()
    _trail()


def _series() -> None:
    series = op.create_table(
        "series",
        _column("pattern", sa.Text(), primary_key=True),
        *(_column(name, sa.Integer()) for name in ("last", "before")),
    )
    earlier = op.get_bind().execute(sa.text("SELECT prefix, year, last FROM numbers")).all()
    for prefix, year, last in earlier:
        pattern = f"{prefix}-{year}-{{serial:04d}}"
        op.execute(series.insert().values(pattern=pattern, last=last, before=last))
    op.drop_table("numbers")


def _certificates() -> None:
    for name in ("purpose", "draft", "dcc", "dcc_sha256"):
        op.add_column("certificates", sa.Column(name, sa.Text(), nullable=True))
    op.add_column("certificates", sa.Column("day", sa.Date(), nullable=True))
    op.execute("UPDATE certificates SET day = due")
    op.drop_index("ix_certificates_due", "certificates")
    op.drop_column("certificates", "due")
    op.alter_column("certificates", "day", new_column_name="due")
    op.create_index("ix_certificates_due", "certificates", ["due"])


def _trail() -> None:
    op.create_table(
        "trail",
        _column("number", sa.Integer(), primary_key=True, autoincrement=False),
        _column("at", sa.DateTime(timezone=True)),
        *(_column(name, sa.Text()) for name in ("person", "action")),
        _column("subject", sa.Text(), index=True),
        *(_column(name, sa.Text()) for name in ("details", "previous_hash", "hash")),
    )
    end = op.create_table(
        "trail_end",
        _column("id", sa.Integer(), primary_key=True, autoincrement=False),
        _column("number", sa.Integer()),
        _column("hash", sa.Text()),
    )
    op.execute(end.insert().values(id=1, number=0, hash=NOTHING_BEFORE))
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


def _column(name: str, kind: Any, *more: Any, **options: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, *more, nullable=False, **options)
