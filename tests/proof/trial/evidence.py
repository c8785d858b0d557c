"""What a trial showed, as data (evidence.json) and as tables (evidence.md)."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from statistics import median
from typing import Any

from tests.proof.report import table
from tests.proof.trial.failures import Failure, failures
from tests.proof.trial.figures import costs, figures
from tests.proof.trial.machine import Machine, this_machine
from tests.proof.trial.score import Score
from tests.proof.trial.table import Rate, Row, by_effect, rows_of, totals_of

COLUMNS = (
    "case", "z", "concealed", "cases", "detected", "first name right", "or its twin", "any wrong",
    "wrong beyond twins", "left unnamed", "effects named", "95 % intervals", "gap closed",
    "of what can be", "off, U", "then, U",
)  # fmt: skip
SUMMARY = (
    "recordings", "", "detected", "first name right", "any wrong", "left unnamed",
    "gap closed", "of what can be", "off, U", "then, U",
)  # fmt: skip
COSTS = (
    "effect", "cases", "concealed", "nothing noticed", "off, U (median)", "off, U (worst)",
    "then, U (median)", "wrong verdicts", "then",
)  # fmt: skip
FAILURES = ("recording", "how", "truth", "z", "named", "procedure", "cause")


@dataclass(frozen=True)
class Trial:
    """A trial that was held. seals: SHA-256 of seals.txt. seconds: all in all, to the scores."""

    seed: int
    short: bool
    code_version: str
    seals: str
    seconds: float
    scores: Sequence[Score]
    machine: Machine = field(default_factory=this_machine)

    @property
    def command(self) -> str:
        """What holds this trial again."""
        return f"make prove --seed {self.seed}{' --short' if self.short else ''}"


def as_data(trial: Trial) -> dict[str, Any]:
    """`mimu-prove/2`: figures, costs, totals, rows by effect and z, failures and every case."""
    return {
        "format": "mimu-prove/2",
        "seed": trial.seed,
        "form": "short" if trial.short else "full",
        "command": trial.command,
        "code_version": trial.code_version,
        "machine": asdict(trial.machine),
        "seals_sha256": trial.seals,
        "seconds": trial.seconds,
        "figures": [asdict(each) | {"what": each.what.en} for each in figures(trial.scores)],
        "costs": [asdict(each) | {"what": each.what.en} for each in costs(trial.scores)],
        "failed": [each.number for each in trial.scores if each.failed],
        "totals": {name: _plain(each) for name, each in totals_of(trial.scores).items()},
        "rows": [_plain(each) for each in rows_of(trial.scores)],
        "failures": [_failure(each) for each in failures(trial.scores)],
        "cases": [_case(each) for each in trial.scores],
    }


def _case(score: Score) -> dict[str, Any]:
    gap = score.gap
    closed = {} if gap is None else {"closed": gap.closed, "of_closable": gap.of_closable}
    return asdict(score) | {"gap": None if gap is None else asdict(gap) | closed}


def _failure(failure: Failure) -> dict[str, Any]:
    causes = [cause.en for cause in failure.causes]
    return {"case": failure.score.number, "kind": failure.kind, "causes": causes}


def _plain(row: Row) -> dict[str, Any]:
    values = ((name, getattr(row, name)) for name in row.__dataclass_fields__)
    return {name: value.response() if isinstance(value, Rate) else value for name, value in values}


def as_markdown(trial: Trial) -> str:
    """What was asked and reached, what missing it costs, all tables and every failure."""
    asked = [(each.what.en, each.asked, each.reached, each.of) for each in figures(trial.scores)]
    cost = [(each.what.en, each.before, each.after) for each in costs(trial.scores)]
    failed = [
        failure_cells(each, "; ".join(cause.en for cause in each.causes))
        for each in failures(trial.scores)
    ]
    return "\n".join([
        f"# The sealed trial, seed {trial.seed}", "",
        f"{len(trial.scores)} recordings, {trial.code_version}, {trial.seconds:.0f} s; SHA-256 "
        f"of the seals {trial.seals}. Intervals in brackets are Wilson's, 95 %.", "",
        *table(("", "asked", "reached", "of"), asked), "",
        *table(("what it costs to miss it", "as the clauses give it", "with explain"), cost), "",
        *(f"- {what}: {figure}" for what, figure in besides(trial)), "",
        *table(COLUMNS, (cells(each, True) for each in totals_of(trial.scores).values())), "",
        *table(COLUMNS, (cells(each, False) for each in rows_of(trial.scores))), "",
        *table(COSTS, map(cost_cells, by_effect(trial.scores))), "", *table(FAILURES, failed), "",
    ])  # fmt: skip


def failure_cells(failure: Failure, cause: str) -> tuple[str, ...]:
    """A failure as words, in the order of FAILURES."""
    score = failure.score
    observation = ", ".join(f"{z:.3g}" for z in score.z.values()) or "–"
    where = f"{score.conditions['procedure']}, {score.conditions['grade']}"
    return score.number, failure.kind, failure.truth, observation, failure.response, where, cause


def cost_cells(row: Row) -> list[str]:
    """What missing an effect costs, in the order of COSTS."""
    return [
        row.name,
        f"{row.wrong_before.of}",
        "–" if row.concealment is None else f"{100 * row.concealment:.0f} %",
        rate_words(row.unnoticed, False),
        *(_ratio(value) for value in (row.before, row.before_most, row.after)),
        rate_words(row.wrong_before, False),
        rate_words(row.wrong_after, False),
    ]


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
        _ratio(row.before),
        _ratio(row.after),
    ]


def _ratio(value: float | None) -> str:
    if value is None:
        return "–"
    if 0.0 < value < 0.01:
        return "< 0.01"
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"


def _number(share: float | None) -> str:
    return "–" if share is None else f"{share:.3f}".replace("-", "−")


def rate_words(rate: Rate, interval: bool) -> str:
    """“12/30”, or “40 % [25, 58]”."""
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
        rows.append((name, f"{each.cases}", *words, *gaps, *cells(each, True)[-2:]))
    return rows


def besides(trial: Trial) -> list[tuple[str, str]]:
    """What holds for the whole trial: (what, figure)."""
    failures = sum(each.failed is not None for each in trial.scores)
    seconds = median(each.seconds for each in trial.scores)
    return [
        ("recordings on which explain failed", f"{failures}"),
        ("one explanation, median", f"{seconds:.1f} s"),
        ("the whole trial", f"{trial.seconds / 60:.1f} min"),
    ]  # fmt: skip
