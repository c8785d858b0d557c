"""How the page looks: the house's colours and type, a switch of language, A4 in print."""

from html import escape

from tasks.model.term import Text

STYLE = """
body { font: 15px/1.5 sans-serif; margin: 2em auto; max-width: 70em; padding: 0 1.2em;
  color: #222; }
h1 { font-size: 1.7em; line-height: 1.25; margin: .2em 0 .5em; }
h2 { font-size: 1.25em; margin: 2em 0 .4em; }
h3 { font-size: 1.1em; margin: 0 0 .4em; }
table { border-collapse: collapse; margin: .6em 0; }
th, td { border-bottom: 1px solid #ddd; padding: 4px 10px 4px 0; text-align: left;
  vertical-align: top; }
th { font-weight: 600; color: #555; }
td.name { white-space: nowrap; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums;
  white-space: nowrap; }
.lead { font-size: 1.07em; max-width: 52em; }
.quiet { color: #666; font-size: .92em; }
.good { color: #14691b; } .bad { color: #a1190d; }
.badge { display: inline-block; padding: 1px 10px; border-radius: 3px; color: #fff;
  font-size: .87em; font-weight: 600; }
.badge.good { background: #14691b; color: #fff; } .badge.bad { background: #a1190d; color: #fff; }
.badge.part { background: #8a5a00; }
.card { border: 1px solid #ddd; border-left: 5px solid #888; border-radius: 4px;
  padding: .9em 1.2em; margin: 1em 0; break-inside: avoid; }
.card dl { display: grid; grid-template-columns: 10.5em 1fr; gap: .35em 1em; margin: .6em 0 0; }
.card dt { color: #555; font-weight: 600; } .card dd { margin: 0; }
.card dd table { margin: 0; }
.disc { display: inline-block; width: 1.5em; line-height: 1.5em; border-radius: 50%;
  text-align: center; color: #fff; margin-right: .4em; font-weight: bold; font-size: .9em; }
.equation { font-family: Georgia, "Times New Roman", serif; font-size: 1.08em; }
figure { margin: 1em 0; break-inside: avoid; } figcaption { color: #555; font-size: .92em; }
figure svg { display: block; height: auto; }
.scroll { overflow-x: auto; }
code { font-size: .92em; overflow-wrap: anywhere; }
input.language { position: absolute; opacity: 0; }
.switch { float: right; margin-left: 1em; }
.switch label { cursor: pointer; padding: 2px 9px; border: 1px solid #bbb; color: #444; }
#english:checked ~ .switch label[for=english], #chinese:checked ~ .switch label[for=chinese] {
  background: #444; color: #fff; border-color: #444; }
#english:focus-visible ~ .switch label[for=english],
#chinese:focus-visible ~ .switch label[for=chinese] { outline: 2px solid #0072b2; }
#english:checked ~ main [lang=zh], #chinese:checked ~ main [lang=en] { display: none; }
@media (max-width: 40em) { .card dl { grid-template-columns: 1fr; } .card dd { margin: 0 0 .5em; } }
@page { size: A4; margin: 14mm; }
@media print {
  body { font-size: 9.5pt; margin: 0; padding: 0; max-width: none; } .switch { display: none; }
  h2, h3 { break-after: avoid; } h2 { margin-top: 1.2em; }
  .card { break-inside: auto; padding: .5em .9em; } .card dt, .card dd, tr { break-inside: avoid; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
"""
NUMBER, NAME = ' class="number"', ' class="name"'
SWITCH = (
    '<input class="language" type="radio" name="language" id="english" checked>'
    '<input class="language" type="radio" name="language" id="chinese">'
    '<div class="switch"><label for="english">English</label>'
    '<label for="chinese">中文</label></div>'
)


def both(text: Text) -> str:
    """A text in both languages, of which the page shows one."""
    en, zh = (escape(each) for each in text)
    return f'<span lang="en">{en}</span><span lang="zh">{zh}</span>'


def table(head: list[str], rows: list[list[str]], numbers: tuple[int, ...] = ()) -> str:
    """A table of cells that are HTML already; `numbers` are the columns set to the right."""
    lines = ['<div class="scroll"><table>']
    for cells, tag in ((head, "th"), *((row, "td") for row in rows)):
        made = (
            f"<{tag}{NUMBER if i in numbers else '' if i else NAME}>{cell}</{tag}>"
            for i, cell in enumerate(cells)
        )
        lines.append(f"<tr>{''.join(made)}</tr>")
    return "\n".join([*lines, "</table></div>"])


def document(title: str, main: list[str]) -> str:
    """A whole page, which needs nothing from elsewhere."""
    return "\n".join(
        [
            '<!doctype html><html lang="en"><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title><style>{STYLE}</style>",
            SWITCH,
            "<main>",
            *main,
            "</main></html>\n",
        ]
    )
