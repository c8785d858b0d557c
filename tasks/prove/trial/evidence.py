"""What a trial showed, as data (evidence.json) and as tables (evidence.md)."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tasks.prove.trial.score import Score
from tasks.prove.trial.table import Rate, Row, rows_of, totals_of

COLUMNS = (
    "case", "z", "concealed", "cases", "detected", "first name right", "or its twin", "any wrong",
    "wrong beyond twins", "abstained", "effects named", "95 % intervals", "gap closed",
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
        "cases": [asdict(each) for each in trial.scores],
    }


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
            *_table(list(totals_of(trial.scores).values()), intervals=True),
            "",
            *_table(rows_of(trial.scores), intervals=False),
            "",
        ]
    )


def _table(rows: list[Row], intervals: bool) -> list[str]:
    head = ["| " + " | ".join(COLUMNS) + " |", "|---" * len(COLUMNS) + "|"]
    return head + ["| " + " | ".join(cells(row, intervals)) + " |" for row in rows]


def cells(row: Row, intervals: bool) -> list[str]:
    """A row as words, in the order of COLUMNS."""
    rates = (
        row.detected, row.right, row.right_or_twin, row.wrong, row.wrong_beyond_twins,
        row.abstained,
    )  # fmt: skip
    many = row.found.of > row.cases
    return [
        row.name,
        "–" if row.z_median is None else f"{row.z_median:.3g}",
        "–" if row.concealment is None else f"{100 * row.concealment:.0f} %",
        f"{row.cases}",
        *(rate_words(rate, intervals) for rate in rates),
        f"{row.found.count}/{row.found.of}" if many else "–",
        f"{row.parameters.count}/{row.parameters.of}" if row.parameters.of else "–",
        "–" if row.gap is None else f"{row.gap:.3f}",
    ]


def rate_words(rate: Rate, interval: bool) -> str:
    """«12/30», or «40 % [25, 58]»."""
    if rate.share is None or rate.interval is None:
        return "–"
    if not interval:
        return f"{rate.count}/{rate.of}"
    low, high = (100 * bound for bound in rate.interval)
    return f"{100 * rate.share:.1f} % [{low:.0f}, {high:.0f}]"


def headline(trial: Trial) -> list[tuple[str, str]]:
    """What the trial comes to: (what, figure)."""
    totals = totals_of(trial.scores)
    every = [pair for each in trial.scores for pair in each.parameters]
    inside = Rate(sum(pair.inside for pair in every), len(every))
    told = [("recordings", f"{len(trial.scores)}")]
    if (clean := totals.get("clean")) is not None:
        told.append(("false alarms on clean ones", _long(clean.detected)))
    for name, each in totals.items():
        if name in ("clean", "cannot be told"):
            continue
        told.append((f"{name}: detected", _long(each.detected)))
        if name == "outside the catalogue":
            told.append((f"{name}: left unnamed", _long(each.abstained)))
        else:
            told.append((f"{name}: first name right", _long(each.right)))
        told.append((f"{name}: any name wrong", _long(each.wrong)))
        if each.gap is not None:
            told.append((f"{name}: gap closed, median", f"{each.gap:.3f}"))
    told.append(("parameters inside their 95 % interval", _long(inside)))
    failures = sum(each.failed is not None for each in trial.scores)
    told.append(("recordings on which explain failed", f"{failures}"))
    seconds = sorted(each.seconds for each in trial.scores)
    told.append(("time of one explanation, median", f"{seconds[len(seconds) // 2]:.1f} s"))
    told.append(("time in all", f"{trial.seconds / 60:.1f} min"))
    return told


def _long(rate: Rate) -> str:
    return f"{rate.count} of {rate.of}: {rate_words(rate, True)}" if rate.of else "–"
