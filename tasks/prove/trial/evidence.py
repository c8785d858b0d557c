"""What a trial showed, as data (evidence.json) and as tables (evidence.md)."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from tasks.prove.trial.score import Score
from tasks.prove.trial.table import Rate, Row, row, rows_of, totals_of

COLUMNS = (
    "case", "z", "concealed", "cases", "detected", "first name right", "or its twin", "any wrong",
    "wrong beyond twins", "left unnamed", "effects named", "95 % intervals", "gap closed",
    "of what can be", "certificate off, U",
)  # fmt: skip
SUMMARY = (
    "recordings", "", "detected", "first name right", "any name wrong", "left unnamed",
    "gap closed", "of what can be", "certificate off, U",
)  # fmt: skip


@dataclass(frozen=True)
class Trial:
    """A trial that was held. seals: SHA-256 of seals.txt. seconds: all in all."""

    seed: int
    short: bool
    code_version: str
    seals: str
    seconds: float
    scores: Sequence[Score]


def as_data(trial: Trial) -> dict[str, Any]:
    """`mimu-prove/1`: totals, rows by effect and z, and every case."""
    return {
        "format": "mimu-prove/1",
        "seed": trial.seed,
        "form": "short" if trial.short else "full",
        "code_version": trial.code_version,
        "seals_sha256": trial.seals,
        "seconds": trial.seconds,
        "failed": [each.number for each in trial.scores if each.failed],
        "totals": {name: _plain(each) for name, each in totals_of(trial.scores).items()},
        "rows": [_plain(each) for each in rows_of(trial.scores)],
        "cases": [_case(each) for each in trial.scores],
    }


def _case(score: Score) -> dict[str, Any]:
    gap = score.gap
    closed = {} if gap is None else {"closed": gap.closed, "of_closable": gap.of_closable}
    return asdict(score) | {"gap": None if gap is None else asdict(gap) | closed}


def _plain(row: Row) -> dict[str, Any]:
    values = ((name, getattr(row, name)) for name in row.__dataclass_fields__)
    return {name: value.said() if isinstance(value, Rate) else value for name, value in values}


def as_markdown(trial: Trial) -> str:
    """Two tables: in all, and by effect and z."""
    count = len(trial.scores)
    return "\n".join(
        [
            f"# The sealed trial, seed {trial.seed}",
            "",
            f"{count} recordings, {trial.code_version}, {trial.seconds:.0f} s; SHA-256 of the "
            f"seals {trial.seals}. Intervals in brackets are Wilson's, 95 %.",
            "",
            *(f"- {what}: {figure}" for what, figure in besides(trial)),
            "",
            *_table(list(totals_of(trial.scores).values()), intervals=True),
            "",
            *_table(rows_of(trial.scores), intervals=False),
            "",
        ]
    )


def _table(rows: list[Row], intervals: bool) -> list[str]:
    head = ["| " + " | ".join(COLUMNS) + " |", "|---" * len(COLUMNS) + "|"]
    return head + ["| " + " | ".join(cells(each, intervals)) + " |" for each in rows]


def cells(row: Row, intervals: bool) -> list[str]:
    """A row as words, in the order of COLUMNS."""
    rates = (
        row.detected, row.right, row.right_or_twin, row.wrong, row.wrong_beyond_twins,
        row.abstained,
    )  # fmt: skip
    many = row.found.of > row.cases
    return [
        row.name,
        "–" if row.z_median is None else f"{round(row.z_median, 1):g}",
        "–" if row.concealment is None else f"{100 * row.concealment:.0f} %",
        f"{row.cases}",
        *(rate_words(rate, intervals) for rate in rates),
        f"{row.found.count}/{row.found.of}" if many else "–",
        f"{row.parameters.count}/{row.parameters.of}" if row.parameters.of else "–",
        *(_number(share) for share in (row.gap, row.of_closable)),
        "–" if row.certificate is None else f"{row.certificate:.2g}",
    ]


def _number(share: float | None) -> str:
    return "–" if share is None else f"{share:.3f}".replace("-", "−")


def rate_words(rate: Rate, interval: bool) -> str:
    """«12/30», or «40 % [25, 58]»."""
    if rate.share is None or rate.interval is None:
        return "–"
    if not interval:
        return f"{rate.count}/{rate.of}"
    low, high = (100 * bound for bound in rate.interval)
    return f"{100 * rate.share:.0f} % [{low:.0f}, {high:.0f}]"


def summary(trial: Trial) -> list[tuple[str, ...]]:
    """The figures that matter, by kind of case; in the order of SUMMARY."""
    rows = []
    for name, each in totals_of(trial.scores).items():
        rates = (each.detected, each.right, each.wrong, each.abstained)
        words = (rate_words(rate, True) for rate in rates)
        gaps = (_number(each.gap), _number(each.of_closable))
        rows.append((name, f"{each.cases}", *words, *gaps, cells(each, True)[-1]))
    return rows


def besides(trial: Trial) -> list[tuple[str, str]]:
    """What holds for the whole trial: (what, figure)."""
    every = [pair for each in trial.scores for pair in each.parameters]
    inside = Rate(sum(pair.inside for pair in every), len(every))
    wrong = row("", None, trial.scores).certificate_wrong
    failures = sum(each.failed is not None for each in trial.scores)
    seconds = median(each.seconds for each in trial.scores)
    return [
        ("parameters inside their 95 % interval",
         f"{inside.count} of {inside.of}: {rate_words(inside, True)}"),
        ("certificates of the standard's clauses that the effects put off by more than U",
         f"{wrong.count} of {wrong.of}: {rate_words(wrong, True)}"),
        ("recordings on which explain failed", f"{failures}"),
        ("one explanation, median", f"{seconds:.1f} s"),
        ("the whole trial", f"{trial.seconds / 60:.1f} min"),
    ]  # fmt: skip
