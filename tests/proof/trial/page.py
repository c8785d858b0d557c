"""evidence.html: the message on the first screen, then pictures, tables and every failure."""

from collections.abc import Sequence
from html import escape

from tasks.explain.report.look import both, document, table
from tests.proof.text import Text
from tests.proof.trial import texts
from tests.proof.trial.evidence import (
    COLUMNS,
    COSTS,
    FAILURES,
    SUMMARY,
    Trial,
    besides,
    cells,
    cost_cells,
    failure_cells,
    summary,
)
from tests.proof.trial.failures import KINDS, failures
from tests.proof.trial.figures import Figure, costs, figures
from tests.proof.trial.pictures.cases import cases_svg
from tests.proof.trial.pictures.cost import cost_svg
from tests.proof.trial.pictures.headline import headline_svg
from tests.proof.trial.pictures.power import effects_svg, families_svg
from tests.proof.trial.table import by_effect, rows_of, totals_of

TILES = 6  # figures of the first screen


def page(trial: Trial, extra_sections: Sequence[str] = ()) -> str:
    """The HTML of a trial, in both languages.

    extra_sections: HTML that stands behind the failures: the peers, real recordings.
    """
    made = figures(trial.scores)
    return document(
        texts.TITLE[0],
        [
            texts.STYLE,
            f"<h1>{both(texts.TITLE)}</h1>",
            f'<p class="lead">{both(texts.message(trial.scores))}</p>',
            f'<div class="tiles">{"".join(map(_tile, made[:TILES]))}</div>',
            _figure(headline_svg(trial.scores), texts.HEADLINE),
            *_asked(made, trial),
            *_cost(trial),
            *_heading(texts.POWER_TITLE),
            _figure(families_svg(trial.scores), texts.FAMILIES),
            _figure(effects_svg(trial.scores), texts.EFFECTS),
            *_heading(texts.FAILURES_TITLE),
            _failures(trial),
            *extra_sections,
            *_heading(texts.PROTOCOL_TITLE),
            f"<p>{both(texts.PROTOCOL)}</p><p>{both(texts.RULES)}</p>",
            *_origin(trial),
            *_heading(texts.CASES_TITLE),
            _figure(cases_svg(trial.scores), texts.CASES),
            *_tables(trial),
        ],
    )


def _tile(figure: Figure) -> str:
    """A figure, what was asked beside it, and whether it was met."""
    mark = {True: ("good", "✓"), False: ("bad", "✗"), None: ("", "")}[figure.met]
    return (
        f'<div class="tile {mark[0]}"><b>{escape(figure.reached)}</b>'
        f"<span>{both(figure.what)}</span>"
        f'<span class="quiet">{both((f"asked: {figure.asked}", f"要求：{figure.asked}"))} '
        f"{mark[1]}</span></div>"
    )


def _asked(made: Sequence[Figure], trial: Trial) -> list[str]:
    marks = {True: "✓", False: "✗", None: "–"}
    rows = [
        [both(each.what), *_cells((each.asked, each.reached, marks[each.met], each.of))]
        for each in made
    ]
    return [
        *_heading(texts.ASKED_TITLE),
        table(["", *map(both, texts.ASKED_HEAD)], rows, (1, 2)),
        f'<p class="quiet">{both(texts.ASKED)}</p>',
        table(["", ""], [_cells(each) for each in besides(trial)]),
    ]


def _cost(trial: Trial) -> list[str]:
    rows = [[both(each.what), each.before, each.after] for each in costs(trial.scores)]
    effects = [_cells(cost_cells(each)) for each in by_effect(trial.scores)]
    return [
        *_heading(texts.COST_TITLE),
        f"<p>{both(texts.COST)}</p>",
        table(["", *map(both, texts.COST_HEAD)], rows, (1, 2)),
        _figure(cost_svg(trial.scores), texts.DUMBBELL),
        _folded(texts.BY_EFFECT, table(list(COSTS), effects, tuple(range(1, len(COSTS))))),
    ]


def _failures(trial: Trial) -> str:
    rows = []
    for each in failures(trial.scores):
        number, _, *told = _cells(failure_cells(each, ""))
        causes = "; ".join(map(both, each.causes))
        rows.append([number, both(KINDS[each.kind]), *told[:-1], causes])
    if not rows:
        return f"<p>{both(('None.', '无。'))}</p>"
    return table(list(FAILURES), rows)


def _origin(trial: Trial) -> list[str]:
    machine = trial.machine
    rows = [
        ("seed", f"{trial.seed}"),
        ("to repeat", trial.command),
        ("code", trial.code_version),
        ("Python, numpy, scipy", f"{machine.python}, {machine.numpy}, {machine.scipy}"),
        ("mimucal", machine.mimucal),
        ("machine", f"{machine.system}, {machine.cores} cores, {trial.seconds / 60:.1f} min"),
        ("SHA-256 of seals.txt", trial.seals),
    ]
    said = [[escape(what), f"<code>{escape(which)}</code>"] for what, which in rows]
    return [*_heading(texts.ORIGIN_TITLE), table(["", ""], said)]


def _tables(trial: Trial) -> list[str]:
    """All the figures by kind, and by effect and z."""
    numbers = tuple(range(1, len(COLUMNS)))
    totals = [_cells(cells(row, True)) for row in totals_of(trial.scores).values()]
    rows = [_cells(cells(row, False)) for row in rows_of(trial.scores)]
    short = [_cells(each) for each in summary(trial)]
    return [
        *_heading(texts.TOTALS_TITLE),
        table(list(SUMMARY), short, tuple(range(1, len(SUMMARY)))),
        _folded(texts.ALL_COLUMNS, table(list(COLUMNS), totals, numbers)),
        _folded(texts.ALL_ROWS, table(list(COLUMNS), rows, numbers)),
    ]


def _folded(what: Text, inside: str) -> str:
    return f"<details><summary>{both(what)}</summary>{inside}</details>"


def _cells(words: Sequence[str]) -> list[str]:
    return [escape(word) for word in words]


def _heading(text: Text) -> list[str]:
    return [f"<h2>{both(text)}</h2>"]


def _figure(picture: str, caption: Text) -> str:
    return f"<figure>{picture}<figcaption>{both(caption)}</figcaption></figure>"
