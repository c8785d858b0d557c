"""What a trial showed, as data (evidence.json) and as tables (evidence.md)."""

import os
import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any

from schemas.text import Statement as Text
from tasks.rendering import inline, page
from tasks.words import Sayable, clauses
from tests.proof.study import bilingual, table
from tests.proof.trial.blind import UNNAMED
from tests.proof.trial.pictures import cases_svg, cost_svg, effects_svg, families_svg, headline_svg
from tests.proof.trial.score import Rate, Row, Score, by_effect, plain_of, rows_of, totals_of

# What a trial was held on: its figures can be had again with the same.


@dataclass(frozen=True)
class Machine:
    """Versions of what computes, and the cores that it computed on."""

    python: str
    numpy: str
    scipy: str
    mimucal: str
    system: str
    cores: int


def this_machine() -> Machine:
    """The one that this runs on; cores: those that this process may use."""
    return Machine(
        python=platform.python_version(),
        numpy=version("numpy"),
        scipy=version("scipy"),
        mimucal=version("mimucal"),
        system=f"{platform.system()} {platform.machine()}",
        cores=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else
        os.cpu_count() or 1,
    )  # fmt: skip


# Why cases fail, as far as somebody has found out; the rest says so.

# By what is true (“clean” where nothing is) and what was said: a name, “unnamed” or “nothing”.
KNOWN_CAUSES: Mapping[tuple[str, str], Text] = {
    **dict.fromkeys(
        (("bandwidth", "time_offset"), ("time_offset", "bandwidth")),
        bilingual(
            "a short delay and a low-pass of second order read alike on a turntable: chi-squared "
            "differs by less than 1",
            "在转台上，短时延与二阶低通的输出几乎相同：卡方之差小于1",
        ),
    ),
    **dict.fromkeys(
        (
            ("thermal_gradient", "temperature_bias"),
            ("temperature_bias", "thermal_gradient"),
            ("thermal_gradient", "thermal_transient"),
            ("thermal_transient", "temperature_bias"),
            ("temperature_bias", "thermal_transient"),
        ),
        bilingual(
            "the unit warms as one exponential: temperature, its rate and a warm-up are then the "
            "same course but for a factor and a bias",
            "产品按单一指数规律升温：温度、温变率与预热漂移仅差一个系数和零偏",
        ),
    ),
    **dict.fromkeys(
        (("vibration_rectification", "nothing"), ("vibration_rectification", "unnamed")),
        bilingual(
            "the vibration that is rectified also makes the readings noisier: rows weigh less "
            "where the effect is large",
            "引起整流的振动同时增大读数噪声：效应大处的数据权重反而较小",
        ),
    ),
    ("bias_random_walk", "nothing"): bilingual(
        "a slow wander this small is within what the flicker noise, itself estimated, may do",
        "如此小的缓慢游走在（同样由数据估计的）闪烁噪声可能范围之内",
    ),
    ("earth_rotation", "nothing"): bilingual(
        "its size is what it is, here below what the unit's noise lets be told",
        "其大小固定，此处低于产品噪声的可分辨限",
    ),
}
NOT_KNOWN: Text = bilingual("not looked into", "尚未查明")
FAINT: Text = bilingual(
    "too faint to be told among all the effects looked for",
    "信号过弱，同时搜索全部因素时无法分辨",
)


# Every case that was not answered right, worst first, with its cause where it is known.

KINDS: dict[str, Text] = {
    "failed": bilingual("explain failed", "解释失败"),
    "false alarm": bilingual("false alarm", "误报"),
    "wrong": bilingual("a wrong name", "名称错误"),
    "unnamed": bilingual("left unnamed", "未予命名"),
    "in part": bilingual("only some of several named", "多个因素仅部分命名"),
    "missed": bilingual("nothing found", "未检出"),
}


@dataclass(frozen=True)
class Failure:
    """One case. kind: of KINDS; causes: one at the least."""

    score: Score
    kind: str
    causes: tuple[Text, ...]

    @property
    def truth(self) -> str:
        return " + ".join(self.score.effects) or "clean"

    @property
    def response(self) -> str:
        return ", ".join(self.score.names) or "nothing"


def failures(scores: Sequence[Score]) -> list[Failure]:
    """Every case that failed, by kind and then by truth and z."""
    kinds = list(KINDS)
    found = [Failure(each, kind, causes(each)) for each in scores if (kind := failing(each))]
    return sorted(
        found, key=lambda f: (kinds.index(f.kind), f.truth, min(f.score.z.values(), default=0.0))
    )


def failing(score: Score) -> str | None:
    """How a case failed; None for one that was answered right, a pair with the truth in it too."""
    if score.failed:
        return "failed"
    if score.wrong_beyond_twins:
        return "wrong" if score.effects else "false alarm"
    if not score.effects:
        return "false alarm" if score.detected else None
    if not score.has_a_name:
        return None if score.detected or not score.can_be_determined else "missed"
    if not score.detected:
        return "missed"
    if not score.right_or_twin:
        return "unnamed"
    return "in part" if score.kind == "several" and len(score.named) < len(score.effects) else None


def causes(score: Score) -> tuple[Text, ...]:
    """What is known of why, by the pairs of what is true and was not said, and what was said.

    What is missed at the faintest z needs no other cause than that.
    """
    found = dict.fromkeys(KNOWN_CAUSES[pair] for pair in _pairs(score) if pair in KNOWN_CAUSES)
    if not found and score.kind == "faint" and not score.detected:
        return (FAINT,)
    return tuple(found) or (NOT_KNOWN,)


def _pairs(score: Score) -> Iterator[tuple[str, str]]:
    response = [*score.wrong, *([UNNAMED] if UNNAMED in score.names else [])]
    if not score.detected or score.kind == "several":
        response.append("nothing")
    for truth in score.effects or ("clean",):
        if truth not in score.named:
            yield from ((truth, name) for name in response)
    yield from ((truth, name) for truth in score.named for name in score.wrong)


# The figures that were asked for, beside what was reached.

FALSE, WRONG, RIGHT, RIGHT_FAINT = 0.01, 0.01, 0.98, 0.90
CLOSED, COVERAGE = 0.97, (0.93, 0.97)


@dataclass(frozen=True)
class Figure:
    """One of the figures. reached and asked in words; of: counts and interval; met: None where
    the trial has no case for it."""

    what: Text
    asked: str
    reached: str
    of: str
    met: bool | None


def figures(scores: Sequence[Score]) -> list[Figure]:
    """What was asked, in the order of the first screen; more than six stand in the table."""
    clean = [each for each in scores if not each.effects]
    outside = [each for each in scores if each.kind == "outside"]
    named = [each for each in scores if each.has_a_name and each.kind == "single"]
    pairs = [pair for each in scores for pair in each.parameters]
    alarms = _rate(clean, "detected")
    wrong = _rate(scores, "wrong_beyond_twins")
    given = _rate(outside, "wrong")
    inside = counting(pair.inside for pair in pairs)
    return [
        _at_most(
            bilingual("false alarms on clean recordings", "无隐藏因素时的误报"), alarms, FALSE
        ),
        *(_right(named, z, least) for z, least in ((30.0, RIGHT), (10.0, RIGHT_FAINT))),
        _at_most(bilingual("recordings with a wrong name", "出现错误名称的记录"), wrong, WRONG),
        _at_most(
            bilingual("outside the catalogue, yet given a name", "目录外因素却被命名"), given, 0.0
        ),
        _closed(named),
        Figure(
            bilingual("parameters inside their stated 95 % interval", "参数真值落在其95 %区间内"),
            f"{100 * COVERAGE[0]:.0f}–{100 * COVERAGE[1]:.0f} %",
            percent(inside),
            counted(inside),
            None if inside.share is None else COVERAGE[0] <= inside.share <= COVERAGE[1],
        ),
    ]


def _at_most(what: Text, rate: Rate, most: float) -> Figure:
    asked = f"≤ {100 * most:g} %" if most else "0 %"
    return Figure(
        what,
        asked,
        percent(rate),
        counted(rate),
        None if rate.share is None else rate.share <= most,
    )


def _right(named: Sequence[Score], z: float, least: float) -> Figure:
    some = [each for each in named if each.asked_z == z]
    rate, pair = _rate(some, "right"), _rate(some, "right_or_twin")
    what = bilingual(f"right name first, z = {z:g}", f"首个名称正确，z = {z:g}")
    of = f"{counted(rate)}; a pair with the truth counted: {percent(pair)}"
    return Figure(
        what,
        f"≥ {100 * least:g} %",
        percent(rate),
        of,
        None if rate.share is None else rate.share >= least,
    )


def _closed(named: Sequence[Score]) -> Figure:
    """Of one effect alone at z 10 and more."""
    gaps = [each.gap for each in named if each.gap is not None and each.asked_z]
    what = bilingual("gap to the truth closed, median", "与真值之差的闭合比例（中位数）")
    asked = f"≥ {CLOSED:g}"
    if not gaps:
        return Figure(what, asked, "–", "no case", None)
    closed = median(gap.closed for gap in gaps)
    closable = [share for gap in gaps if (share := gap.of_closable) is not None]
    of = f"{len(gaps)} recordings, z 10 to 100"
    if closable:
        of += f"; of what noise lets be closed {median(closable):.3f}"
    return Figure(what, asked, f"{closed:.3f}", of, closed >= CLOSED)


@dataclass(frozen=True)
class CostLine:
    """What missing the physics costs: as the clauses give it, and with what explain found."""

    what: Text
    before: str
    after: str


def costs(scores: Sequence[Score]) -> list[CostLine]:
    """Over the recordings that hide something; empty where none of them has a certificate."""
    kept = [(each, each.cost) for each in scores if each.effects and each.cost is not None]
    if not kept:
        return []
    known = [cost for _, cost in kept]
    unseen = [not each.names for each, _ in kept]
    return [
        CostLine(
            bilingual("certificates off by more than their stated U", "偏差超过所声明U的证书"),
            words(counting(cost.before > 1.0 for cost in known)),
            words(counting(cost.after > 1.0 for cost in known)),
        ),
        CostLine(
            bilingual(
                "largest error of a value, median over the certificates", "证书最大偏差的中位数"
            ),
            f"{median(cost.before for cost in known):.2g} U",
            f"{median(cost.after for cost in known):.2g} U",
        ),
        CostLine(
            bilingual("units that fail and are passed", "实际不合格却判为合格"),
            words(counting(cost.wrong_before and not cost.conforms for cost in known)),
            words(counting(cost.wrong_after and not cost.conforms for cost in known)),
        ),
        CostLine(
            bilingual("units that conform and are failed", "实际合格却判为不合格"),
            words(counting(cost.wrong_before and cost.conforms for cost in known)),
            words(counting(cost.wrong_after and cost.conforms for cost in known)),
        ),
        CostLine(
            bilingual("units that cannot be judged, U has grown too large", "因U过大而无法判定"),
            words(counting(cost.verdict_before == "inconclusive" for cost in known)),
            words(counting(cost.verdict_after == "inconclusive" for cost in known)),
        ),
        CostLine(
            bilingual("recordings on which nothing was noticed", "未察觉任何异常的记录"),
            words(counting(cost.unnoticed for cost in known)),
            words(counting(unseen)),
        ),
    ]


def counting(holds: Iterable[bool]) -> Rate:
    """How many of some hold."""
    listed = list(holds)
    return Rate(sum(listed), len(listed))


def _rate(scores: Sequence[Score], holds: str) -> Rate:
    return counting(bool(getattr(each, holds)) for each in scores)


def percent(rate: Rate) -> str:
    """“12 %”, with a decimal below ten."""
    if rate.share is None:
        return "–"
    share = 100 * rate.share
    return f"{share:.1f} %" if 0 < share < 10 or 90 < share < 100 else f"{share:.0f} %"


def counted(rate: Rate) -> str:
    """“1 of 120 [0.1, 4.6]”, the interval in percent."""
    if rate.interval is None:
        return "no case"
    low, high = (100 * bound for bound in rate.interval)
    return f"{rate.count} of {rate.of} [{low:.1f}, {high:.1f}]"


def words(rate: Rate) -> str:
    """“12 % (36 of 300)”."""
    return f"{percent(rate)} ({rate.count} of {rate.of})"


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
        short = " --short" if self.short else ""
        return f'make prove ARGS="trial --seed {self.seed}{short}"'


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
        "totals": {name: plain_of(each) for name, each in totals_of(trial.scores).items()},
        "rows": [plain_of(each) for each in rows_of(trial.scores)],
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


# evidence.html: the message on the first screen, then pictures, tables and every failure.

TEMPLATE = Path(__file__).parent / "templates" / "evidence.html"
PICTURES = {
    "headline": headline_svg, "cost": cost_svg, "families": families_svg,
    "effects": effects_svg, "cases": cases_svg,
}  # fmt: skip

Table = tuple[Sequence[Sayable], Sequence[Sequence[Sayable]], tuple[int, ...]]


def evidence_html(trial: Trial, extra_sections: Sequence[str] = ()) -> str:
    """The HTML of a trial, in both languages.

    extra_sections: HTML that stands behind the failures: the peers, real recordings.
    """
    scores = trial.scores
    return page(
        TEMPLATE,
        lead=lead(scores),
        figures=figures(scores),
        besides=besides(trial),
        costs=costs(scores),
        pictures={name: inline(draw(scores)) for name, draw in PICTURES.items()},
        by_effect=_table(COSTS, [cost_cells(row) for row in by_effect(scores)]),
        failure_columns=FAILURES,
        failures=_failures(scores),
        extra_sections=[inline(section) for section in extra_sections],
        origin=_origin(trial),
        summary=_table(SUMMARY, summary(trial)),
        totals=_table(COLUMNS, [cells(row, True) for row in totals_of(scores).values()]),
        rows=_table(COLUMNS, [cells(row, False) for row in rows_of(scores)]),
    )


def lead(scores: Sequence[Score]) -> Text:
    """The whole page in one sentence."""
    hidden = [score for score in scores if score.effects]
    known = [score.cost for score in hidden if score.cost is not None]
    off = percent(counting(cost.before > 1.0 for cost in known))
    still = percent(counting(cost.after > 1.0 for cost in known))
    blind = percent(counting(cost.unnoticed for cost in known))
    right = percent(counting(score.right_or_twin for score in hidden if score.has_a_name))
    return bilingual(
        f"{len(hidden)} of {len(scores)} recordings hide physics that the standard's model leaves "
        f"out: its certificate is then wrong by more than it admits in {off} of them, and in "
        f"{blind} nothing would have been noticed; explain names it right in {right}, and with "
        f"that taken off {still} stay wrong.",
        f"{len(scores)}个记录中有{len(hidden)}个隐藏了规范模型未包含的物理因素：其中{off}的证书"
        f"偏差超过所声明的不确定度，{blind}不会被察觉；失配解释正确命名了其中的{right}，扣除之后"
        f"仍有偏差的为{still}。",
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """Head, rows, and every column but the first set to the right."""
    return head, rows, tuple(range(1, len(head)))


def _failures(scores: Sequence[Score]) -> list[list[Sayable]]:
    rows: list[list[Sayable]] = []
    for failure in failures(scores):
        number, _, *others, _ = failure_cells(failure, "")
        rows.append([number, KINDS[failure.kind], *others, clauses(failure.causes)])
    return rows


def _origin(trial: Trial) -> list[tuple[str, str]]:
    machine = trial.machine
    return [
        ("seed", f"{trial.seed}"),
        ("to repeat", trial.command),
        ("code", trial.code_version),
        ("Python, numpy, scipy", f"{machine.python}, {machine.numpy}, {machine.scipy}"),
        ("mimucal", machine.mimucal),
        ("machine", f"{machine.system}, {machine.cores} cores, {trial.seconds / 60:.1f} min"),
        ("SHA-256 of seals.txt", trial.seals),
    ]
