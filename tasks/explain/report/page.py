"""The report as a folder: a page to read, its pictures, the answer and the prediction as data."""

from pathlib import Path

from schemas.discrepancy import Discrepancy
from tasks.explain.explanation import Explanation
from tasks.explain.report.before_after import before_after_svg
from tasks.explain.report.excess import cells_of
from tasks.explain.report.files import appear, prediction
from tasks.explain.report.look import both, document
from tasks.explain.report.sections import card, consequences, held_out, method, origins
from tasks.explain.report.verdicts import HEADLINES
from tasks.explain.report.where import where_svg
from tasks.explain.report.words import text_of
from tasks.model.term import Text

BADGES: dict[str, tuple[str, Text]] = {
    "no_mismatch": ("good", ("no mismatch", "未见失配")),
    "explained": ("good", ("explained", "已查明")),
    "partly_explained": ("part", ("partly explained", "部分查明")),
    "unexplained": ("bad", ("unexplained", "未查明")),
}
WHERE: Text = (
    "Colour: by how many standard deviations the misfit of the standard's model stands above "
    "noise, at the averaging time at which it shows most. The strip above tells rests, rates and "
    "turns; bars below a channel tell in which segments a finding sits, the numbers at the right "
    "its share.",
    "颜色表示规范模型的失配高出噪声多少倍标准差（取最显著的平均时间）。上方色带为静止、恒速与转动区段；"
    "各通道下方的短条为各项发现所在的区段，右侧数字为其占比。",
)
NOWHERE: Text = (
    "Colour: by how many standard deviations the misfit of the standard's model stands above "
    "white noise, at the averaging time at which it shows most. Single pale cells are the unit's "
    "own slow noise: all in all there is no more than chance allows.",
    "颜色表示规范模型的失配高出白噪声多少倍标准差（取最显著的平均时间）。个别浅色格为被校单元自身的慢变噪声，"
    "总体未超出偶然范围。",
)
BEFORE_AFTER: Text = (
    "Left: means of the residual over time; pale bars show what swings within a cell. Right: "
    "spectrum of the residual divided by the noise of a sample.",
    "左：残差随时间的分段平均，浅色条为段内的摆动。右：残差除以单次采样噪声后的频谱。",
)
ONLY_NOISE: Text = (
    "Left: means of the residual over time. Right: spectrum of the residual divided by the noise "
    "of a sample; a rise at low frequencies is the flicker and drift of the unit's own noise.",
    "左：残差随时间的分段平均。右：残差除以单次采样噪声后的频谱；低频处的上升为被校单元自身的闪烁噪声与漂移。",
)


def write_report(
    discrepancy: Discrepancy, explanation: Explanation, folder: Path
) -> tuple[Path, ...]:
    """Writes report.html, report.json, where.svg, before_after.svg and prediction.parquet.

    Each file appears whole or not at all; the page comes last. Returns their paths. Raises
    Unusable where the folder cannot be written.
    """
    cells = cells_of(explanation)
    where = where_svg(discrepancy, cells)
    before_after = before_after_svg(explanation, cells)
    contents = {
        "prediction.parquet": prediction(explanation),
        "where.svg": where.encode(),
        "before_after.svg": before_after.encode(),
        "report.json": (discrepancy.model_dump_json(indent=1) + "\n").encode(),
        "report.html": page(discrepancy, explanation, where, before_after).encode(),
    }
    return tuple(appear(folder, name, content) for name, content in contents.items())[::-1]


def page(discrepancy: Discrepancy, explanation: Explanation, where: str, before_after: str) -> str:
    """The HTML of a report: one file, both languages, with its pictures in it."""
    look, badge = BADGES[discrepancy.verdict]
    cards = [card(number, finding) for number, finding in enumerate(discrepancy.findings)]
    recording_id = discrepancy.recording_id
    return document(
        f"Model and recording: {recording_id}",
        [
            f'<p><span class="badge {look}">{both(badge)}</span></p>',
            f"<h1>{both(HEADLINES[discrepancy.verdict])}</h1>",
            f'<p class="lead">{both(text_of(discrepancy.statement))}</p>',
            *_heading("Where", "所在位置"),
            _figure(where, WHERE if cards else NOWHERE),
            *([*_heading("What was left out", "遗漏的物理因素"), *cards] if cards else []),
            *(_heading("Before and after", "前后对比") if cards
              else _heading("What is left over", "剩余残差")),
            _figure(before_after, BEFORE_AFTER if cards else ONLY_NOISE),
            held_out(discrepancy.held_out),
            *([*_heading("The certificate", "对证书的影响"), consequences(discrepancy)]
              if cards else []),
            *_remarks(discrepancy),
            *_heading("Method and false alarms", "方法与误报率"),
            method(explanation),
            *_heading("Origin", "来源"),
            origins(explanation),
        ],
    )  # fmt: skip


def _heading(en: str, zh: str) -> list[str]:
    return [f"<h2>{both((en, zh))}</h2>"]


def _figure(picture: str, caption: Text) -> str:
    return f"<figure>{picture}<figcaption>{both(caption)}</figcaption></figure>"


def _remarks(discrepancy: Discrepancy) -> list[str]:
    if not discrepancy.remarks:
        return []
    told = "".join(f"<li>{both(text_of(remark))}</li>" for remark in discrepancy.remarks)
    return [*_heading("Remarks", "说明"), f"<ul>{told}</ul>"]
