"""What a trial showed: as data (evidence.json), as tables (evidence.md), and in one picture."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from tasks.rendering import GREY, INK, PALE, draw
from tests.proof.study import table
from tests.proof.trial.parameters import power
from tests.proof.trial.score import Cost, Rate, Row, Score, by_effect, rows_of, totals_of


@dataclass(frozen=True)
class Trial:
    """A trial that was held. seals: SHA-256 of seals.txt. seconds: all in all, to the scores."""

    seed: int
    short: bool
    code_version: str
    seals: str
    seconds: float
    scores: Sequence[Score]


def as_data(trial: Trial) -> dict[str, Any]:
    """`mimu-prove/3`: what was held, and every case."""
    cases = [
        asdict(each) | {"gap": each.gap and asdict(each.gap) | {"closed": each.gap.closed}}
        for each in trial.scores
    ]
    return {
        "format": "mimu-prove/3", "seed": trial.seed, "form": "short" if trial.short else "full",
        "code_version": trial.code_version, "seals_sha256": trial.seals, "seconds": trial.seconds,
        "cases": cases,
    }  # fmt: skip


def as_markdown(trial: Trial) -> str:
    """What was asked and reached, what missing it costs, all tables and every failure."""
    scores = trial.scores
    short = " --short" if trial.short else ""
    return "\n".join([
        f"# The sealed trial, seed {trial.seed}", "",
        f'`make prove ARGS="trial --seed {trial.seed}{short}"`: {len(scores)} recordings, '
        f"{trial.code_version}, {trial.seconds:.0f} s; SHA-256 of the seals {trial.seals}. "
        "Intervals in brackets are Wilson's, 95 %.", "",
        *table(("", "asked", "reached", "of"), figures(scores)), "",
        *table(("what it costs to miss it", "as the clauses give it", "with explain"),
               costs(scores)), "",
        f"- recordings on which explain failed: {sum(each.failed is not None for each in scores)}",
        f"- one explanation, median: {median(each.seconds for each in scores):.1f} s", "",
        *table(COLUMNS, (cells(each, True) for each in totals_of(scores).values())), "",
        *table(COLUMNS, (cells(each, False) for each in rows_of(scores))), "",
        *table(COSTS, map(cost_cells, by_effect(scores))), "",
        *table(FAILURES, failures(scores)), "",
    ])  # fmt: skip


# The figures that were asked for, beside what was reached.

FALSE, WRONG, RIGHT, RIGHT_FAINT = 0.01, 0.01, 0.98, 0.90
CLOSED, COVERAGE = 0.97, (0.93, 0.97)
Asked = tuple[str, str, str, str]  # what, asked, reached, of how many


def figures(scores: Sequence[Score]) -> list[Asked]:
    """What was asked, the most important first."""
    clean = [each for each in scores if not each.effects]
    outside = [each for each in scores if each.kind == "outside"]
    named = [each for each in scores if each.has_a_name and each.kind == "single"]
    inside = counting(pair.inside for each in scores for pair in each.parameters)
    return [
        _at_most("false alarms on clean recordings", FALSE, (each.detected for each in clean)),
        *(_right(named, z, least) for z, least in ((30.0, RIGHT), (10.0, RIGHT_FAINT))),
        _at_most("recordings with a wrong name", WRONG,
                 (bool(each.wrong_beyond_twins) for each in scores)),
        _at_most("outside the catalogue, yet given a name", 0.0,
                 (bool(each.wrong) for each in outside)),
        _closed(named),
        ("parameters inside their stated 95 % interval",
         f"{100 * COVERAGE[0]:.0f}–{100 * COVERAGE[1]:.0f} %", percent(inside), counted(inside)),
    ]  # fmt: skip


def _at_most(what: str, most: float, holds: Iterable[bool]) -> Asked:
    rate = counting(holds)
    return what, f"≤ {100 * most:g} %", percent(rate), counted(rate)


def _right(named: Sequence[Score], z: float, least: float) -> Asked:
    some = [each for each in named if each.asked_z == z]
    rate = counting(each.right for each in some)
    pair = percent(counting(each.right_or_twin for each in some))
    of = f"{counted(rate)}; a pair with the truth counted: {pair}"
    return f"right name first, z = {z:g}", f"≥ {100 * least:g} %", percent(rate), of


def _closed(named: Sequence[Score]) -> Asked:
    """Of one effect alone at z 10 and more."""
    gaps = [each.gap for each in named if each.gap is not None and each.asked_z]
    what, asked = "gap to the truth closed, median", f"≥ {CLOSED:g}"
    if not gaps:
        return what, asked, "–", "no case"
    closable = [share for gap in gaps if (share := gap.of_closable) is not None]
    of = f"{len(gaps)} recordings, z 10 to 100"
    if closable:
        of += f"; of what noise lets be closed {median(closable):.3f}"
    return what, asked, f"{median(gap.closed for gap in gaps):.3f}", of


def costs(scores: Sequence[Score]) -> list[tuple[str, str, str]]:
    """What missing the physics costs, over the recordings that hide something: as the clauses give
    it, and with what explain found; empty where none of them has a certificate.
    """
    kept = [(each, each.cost) for each in scores if each.effects and each.cost is not None]
    known: list[Cost] = [cost for _, cost in kept]
    if not known:
        return []

    def row(what: str, before: Iterable[bool], after: Iterable[bool]) -> tuple[str, str, str]:
        return what, words(counting(before)), words(counting(after))

    return [
        row("certificates off by more than their stated U",
            (cost.before > 1.0 for cost in known), (cost.after > 1.0 for cost in known)),
        ("largest error of a value, median over the certificates",
         f"{median(cost.before for cost in known):.2g} U",
         f"{median(cost.after for cost in known):.2g} U"),
        row("units that fail and are passed",
            (cost.wrong_before and not cost.conforms for cost in known),
            (cost.wrong_after and not cost.conforms for cost in known)),
        row("units that conform and are failed",
            (cost.wrong_before and cost.conforms for cost in known),
            (cost.wrong_after and cost.conforms for cost in known)),
        row("units that cannot be judged, U has grown too large",
            (cost.verdict_before == "inconclusive" for cost in known),
            (cost.verdict_after == "inconclusive" for cost in known)),
        row("recordings on which nothing was noticed",
            (cost.unnoticed for cost in known), (not each.names for each, _ in kept)),
    ]  # fmt: skip


# Every case that was not answered right, worst first.

KINDS = ("failed", "false alarm", "wrong", "unnamed", "in part", "missed")
FAILURES = ("recording", "how", "truth", "z", "named", "procedure")


def failures(scores: Sequence[Score]) -> list[tuple[str, ...]]:
    """By kind and then by truth and z; in the order of FAILURES."""
    found = [(kind, each) for each in scores if (kind := failing(each))]
    found.sort(key=lambda f: (KINDS.index(f[0]), f[1].effects, min(f[1].z.values(), default=0.0)))
    return [
        (
            each.number, kind, " + ".join(each.effects) or "clean",
            ", ".join(f"{z:.3g}" for z in each.z.values()) or "–",
            ", ".join(each.names) or "nothing",
            f"{each.conditions['procedure']}, {each.conditions['grade']}",
        )
        for kind, each in found
    ]  # fmt: skip


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


# Rates and rows as words.

COLUMNS = (
    "case", "z", "concealed", "cases", "detected", "first name right", "or its twin", "any wrong",
    "wrong beyond twins", "left unnamed", "effects named", "95 % intervals", "gap closed",
    "of what can be", "off, U", "then, U",
)  # fmt: skip
COSTS = (
    "effect", "cases", "concealed", "nothing noticed", "off, U (median)", "off, U (worst)",
    "then, U (median)", "wrong verdicts", "then",
)  # fmt: skip


def counting(holds: Iterable[bool]) -> Rate:
    """How many of some hold."""
    listed = list(holds)
    return Rate(sum(listed), len(listed))


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


def rate_words(rate: Rate, interval: bool) -> str:
    """“12/30”, or “40 % [25, 58]”."""
    if rate.share is None or rate.interval is None:
        return "–"
    if not interval:
        return f"{rate.count}/{rate.of}"
    low, high = (100 * bound for bound in rate.interval)
    return f"{100 * rate.share:.0f} % [{low:.0f}, {high:.0f}]"


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
        *("–" if share is None else f"{share:.3f}" for share in (row.gap, row.of_closable)),
        _ratio(row.before),
        _ratio(row.after),
    ]


def _ratio(value: float | None) -> str:
    if value is None:
        return "–"
    if 0.0 < value < 0.01:
        return "< 0.01"
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"


# The one picture for a reader in a hurry: who is named, beside the limit; and how well hidden.

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIMIT = "#009e73"
OUTCOMES = {
    "right": "#0072b2", "pair": "#56b4e9", "unnamed": "#bbbbbb", "missed": "#ffffff",
    "wrong": "#d55e00",
}  # fmt: skip
OUTLINE: dict[str, Any] = {"edgecolor": GREY, "linewidth": 0.6}
LOWEST, HIGHEST = 2.0, 200.0  # z that is shown
TICKS = (3, 10, 30, 100)
BINS = 10
Z_OF_ALL = "z: signal beside the noise, after the standard's parameters took their part"
BARS = "* or a pair that holds the truth; bars: 95 % intervals"
TITLE: dict[str, Any] = {"fontsize": 15, "pad": 38}
Holds = Callable[[Score], object]
SHARES: tuple[tuple[str, str, Holds], ...] = (
    ("detected", INK, lambda score: score.detected),
    ("named right*", OUTCOMES["right"], lambda score: score.right_or_twin),
    ("a wrong name", OUTCOMES["wrong"], lambda score: score.wrong_beyond_twins),
)


def headline_svg(scores: Sequence[Score]) -> str:
    """Left: shares detected, named and wrongly named over z. Right: cases by concealment."""
    kept = [each for each in scores if each.kind in ("single", "faint") and each.asked_z]

    def content(figure: "Figure") -> None:
        naming, hiding = figure.subplots(1, 2)
        naming.set_title("One effect alone: is it named?", **TITLE)
        series = ((name, colour) for name, colour, _ in SHARES)
        _legend(naming, [*series, ("limit: knows the effect's form", LIMIT)])
        _draw_power(naming, kept)
        naming.set_xlabel(Z_OF_ALL, loc="right")
        naming.annotate(BARS, (1, 0), xytext=(0, -44), xycoords="axes fraction", color=GREY,
                        textcoords="offset points", ha="right")  # fmt: skip
        hiding.set_title("How much of it do the standard's parameters hide?", **TITLE)
        _legend(hiding, OUTCOMES.items())
        _draw_hiding(hiding, kept)

    return draw("Naming over visibility, and what the standard hides", 1040, 430, content)


def outcome(score: Score) -> str:
    """The worst that can be said of a case, first: of OUTCOMES."""
    if score.wrong_beyond_twins:
        return "wrong"
    nameless = not score.has_a_name and (score.abstained or not score.can_be_determined)
    if score.right or nameless:
        return "right"
    if score.right_or_twin:
        return "pair"
    return "unnamed" if score.abstained else "missed"


def rates_by_z(scores: Sequence[Score], holds: Holds) -> list[tuple[float, Rate]]:
    """How many of the cases of each z asked it holds for."""
    groups: dict[float, list[Score]] = {}
    for score in scores:
        groups.setdefault(score.asked_z or 0.0, []).append(score)
    return [
        (z, Rate(sum(bool(holds(score)) for score in group), len(group)))
        for z, group in sorted(groups.items())
    ]


def limit_of(scores: Sequence[Score]) -> Callable[[float], float]:
    """The power of a detector that knows the form, in the mean over these cases."""
    counts = [next(iter(score.freedom.values())) for score in scores]
    shares = {k: counts.count(k) / len(counts) for k in set(counts)}
    return lambda z: sum(share * power(z, k) for k, share in shares.items())


def _legend(axes: Any, entries: Iterable[tuple[str, str]]) -> None:
    """Coloured squares with their words, in one line below the title."""
    from matplotlib.patches import Patch

    handles = [Patch(facecolor=colour, label=words, **OUTLINE) for words, colour in entries]
    axes.legend(handles=handles, ncols=len(handles), handlelength=1.0, handleheight=1.0,
                columnspacing=1.2, handletextpad=0.5, loc="lower left", bbox_to_anchor=(0, 1.03),
                borderpad=0, borderaxespad=0, fontsize=11)  # fmt: skip


def _draw_power(axes: Any, cases: Sequence[Score]) -> None:
    """Shares over z beside the limit; what is beside others at the same z is shifted a little."""
    z = np.geomspace(LOWEST, HIGHEST, 61)
    if cases:
        axes.plot(z, [limit_of(cases)(at) for at in z], color=LIMIT, linewidth=1.6)
    for k, (_, colour, holds) in enumerate(SHARES):
        shown = [(at, r.share, r.interval) for at, r in rates_by_z(cases, holds)
                 if r.share is not None and r.interval is not None]  # fmt: skip
        if shown:
            at, share, interval = (np.array(column) for column in zip(*shown, strict=True))
            bars = np.abs(interval.T - share)
            axes.errorbar(at * (1.0 + 0.08 * (k - 1)), share, bars, color=colour, fmt="-o",
                          markersize=5.0, linewidth=1.0, elinewidth=1.3)  # fmt: skip
    axes.set(xscale="log", xlim=(LOWEST, HIGHEST), ylim=(-0.03, 1.03))
    axes.set_xticks(TICKS, [f"{tick}" for tick in TICKS])
    axes.set_yticks([0.0, 0.5, 1.0], ["0 %", "50 %", "100 %"])
    axes.minorticks_off()
    axes.grid(axis="y", color=PALE)
    axes.set_axisbelow(True)
    axes.spines["left"].set_visible(False)
    axes.tick_params(length=0, labelcolor=GREY)


def _draw_hiding(axes: Any, cases: Sequence[Score]) -> None:
    """Recordings by the share that is hidden, stacked by outcome, with the count on top."""
    shares = np.array([score.concealment[score.effects[0]] for score in cases])
    bins = np.minimum((shares * BINS).astype(int), BINS - 1)
    outcomes = np.array([outcome(score) for score in cases])
    foot = np.zeros(BINS)
    middles = (np.arange(BINS) + 0.5) / BINS
    for name, colour in OUTCOMES.items():
        counts = np.bincount(bins[outcomes == name], minlength=BINS)
        edge = OUTLINE if name == "missed" else {}
        axes.bar(middles, counts, 0.85 / BINS, foot, color=colour, **edge)
        foot = foot + counts
    for x, height in zip(middles, foot, strict=True):
        if height:
            axes.annotate(f"{height:.0f}", (x, height), xytext=(0, 3), ha="center",
                          textcoords="offset points")  # fmt: skip
    axes.set(xlim=(0, 1), ylim=(0, 1.1 * (foot.max() or 1)), yticks=[])
    axes.spines["left"].set_visible(False)
    axes.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axes.set_xlabel("share of the effect's power that they absorb; height: recordings", loc="right")
