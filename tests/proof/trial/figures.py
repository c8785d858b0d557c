"""The figures that were asked for, beside what was reached."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from tests.proof.text import Text, bilingual
from tests.proof.trial.score import Score
from tests.proof.trial.table import Rate

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
