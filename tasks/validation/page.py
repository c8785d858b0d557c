"""A validation record as a page to read: one self-contained file with a picture and a table."""

from collections.abc import Sequence
from html import escape

from schemas.validation import EVIDENCE, Coverage, ItemValidation, ValidationRecord
from tasks.validation.coverage import ASKED

SCALE = (0.88, 1.0)  # shares shown in the picture
WIDTH, ROW, LEFT = 900, 22, 380
STYLE = """
body { font: 15px/1.5 sans-serif; margin: 2em auto; max-width: 70em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { border-bottom: 1px solid #ddd; padding: 4px 6px; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.yes { color: #14691b; } .no { color: #a1190d; font-weight: bold; }
svg text { font: 13px sans-serif; }
"""


def page(record: ValidationRecord) -> str:
    """The HTML of a record."""
    rows = [
        (m, n, item) for m, method in record.methods.items() for n, item in method.items.items()
    ]
    valid = sum(item.valid for _, _, item in rows)
    prints = ", ".join(f"{name} {m.fingerprint}" for name, m in record.methods.items())
    return "\n".join(
        [
            '<!doctype html><html lang="en"><meta charset="utf-8">',
            f"<title>Validation of the estimation</title><style>{STYLE}</style>",
            "<h1>Validation of the estimation</h1>",
            f"<p>{valid} of {len(rows)} items are validated. Made on {record.made_on} with "
            f"{escape(record.code_version)}, seed {record.seed}, in {record.seconds:.0f} s. "
            f"Fingerprints of the source: {escape(prints)}.</p>",
            "<p>Each unit is simulated with the physics of the virtual station: noise is white, "
            "or white and flicker of a strength of its own; errors of table, fixture, gravity and "
            "latitude are drawn for each run within the limits that the budgets claim. An item is "
            "validated if its worked example comes out, an ideal run gives the truth back, other "
            "programs agree, and its stated 95 % intervals hold the truth in at least "
            f"{100 * ASKED[0]:.0f} % of the cases (the aim is up to {100 * ASKED[1]:.0f} %: what "
            "lies above is longer than it need be).</p>",
            _picture([(f"{m}: {n}", i.coverage) for m, n, i in rows if i.coverage]),
            _table(rows),
            _details(rows),
            "</html>\n",
        ]
    )


def _table(rows: Sequence[tuple[str, str, ItemValidation]]) -> str:
    head = ("method", "item", "units", "inside 95 %", "(95 % of that)", "inside U", "rms z",
            *EVIDENCE, "valid")  # fmt: skip
    lines = ["<table><tr>" + "".join(f"<th>{each}</th>" for each in head) + "</tr>"]
    for method, name, item in rows:
        cells = [f"<td>{escape(method)}</td><td>{escape(name)}</td>", *_figures(item.coverage)]
        for kind in EVIDENCE:
            cells.append(_mark(kind in item.checks and item.checks[kind].passed))
        lines.append(f"<tr>{''.join(cells)}{_mark(item.valid)}</tr>")
    return "\n".join([*lines, "</table>"])


def _figures(coverage: Coverage | None) -> list[str]:
    if coverage is None:
        return ['<td class="number">-</td>'] * 5
    low, high = coverage.confidence
    told = (
        f"{coverage.units}",
        f"{100 * coverage.inside_95:.1f} %",
        f"{100 * low:.1f} to {100 * high:.1f} %",
        f"{100 * coverage.inside_expanded:.1f} %",
        f"{coverage.rms_z:.2f}",
    )
    return [f'<td class="number">{each}</td>' for each in told]


def _mark(passed: bool) -> str:
    return f'<td class="{"yes" if passed else "no"}">{"yes" if passed else "no"}</td>'


def _details(rows: Sequence[tuple[str, str, ItemValidation]]) -> str:
    lines = ["<h2>In words</h2>"]
    for method, name, item in rows:
        lines.append(f"<h3>{escape(method)}: {escape(name)}</h3><ul>")
        for kind, check in item.checks.items():
            word = "yes" if check.passed else "no"
            lines.append(
                f'<li><b>{kind}</b> <span class="{word}">{word}</span>: {escape(check.en)}.'
                f"<br>{escape(check.zh)}。</li>"
            )
        if item.coverage:
            each = ", ".join(f"{e} {100 * s:.1f} %" for e, s in item.coverage.by_element.items())
            lines.append(f"<li>each element: {escape(each)}</li>")
        lines.append("</ul>")
    return "\n".join(lines)


def _picture(rows: list[tuple[str, Coverage]]) -> str:
    """Shares inside the 95 % interval with their own intervals, against what is asked."""
    height = ROW * (len(rows) + 2)
    low, high = _x(ASKED[0]), _x(ASKED[1])
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {height}" role="img" width="100%">',
        f'<rect x="{low}" y="0" width="{high - low}" height="{height - ROW}" fill="#dcefdc"/>',
    ]
    for i, (name, coverage) in enumerate(rows):
        y = ROW * (i + 0.8)
        start, end = map(_x, coverage.confidence)
        inside = ASKED[0] <= coverage.inside_95 <= ASKED[1]
        colour = "#14691b" if inside else "#a1190d"
        parts.append(f'<text x="0" y="{y + 5}">{escape(name)}</text>')
        parts.append(
            f'<line x1="{start}" x2="{end}" y1="{y}" y2="{y}" stroke="{colour}" stroke-width="2"/>'
            f'<circle cx="{_x(coverage.inside_95)}" cy="{y}" r="4" fill="{colour}"/>'
        )
    for percent in range(88, 101, 2):
        x = _x(percent / 100)
        parts.append(f'<text x="{x}" y="{height - 4}" text-anchor="middle">{percent} %</text>')
    return "\n".join([*parts, "</svg>"])


def _x(share: float) -> float:
    part = (max(share, SCALE[0]) - SCALE[0]) / (SCALE[1] - SCALE[0])
    return round(LEFT + part * (WIDTH - LEFT - 30), 1)
