"""The sentences of the certificate: basis, uncertainty, reasons, readings taken, remarks."""

import math
import re

from schemas.calibration import Calibration, Item, Remark
from schemas.tolerance import Decision
from tasks.certificate.appendix import TABLE_ITEMS
from tasks.certificate.equipment import whose_limits
from tasks.certificate.fields import given, listed
from tasks.certificate.names import Pair, item_name, pair_of
from tasks.certificate.typography import clause, pair
from tasks.words.rounding import USUAL_K

FOLLOWED = ("本次校准依据 {}", "Calibrated according to {}")
DEVIATED = (
    "本次校准参照 {}，有偏离，见“说明”",
    "Calibrated after {}, with deviations, see Remarks",
)
FITTED = (
    "参照 {} 的模型式(1)、式(2)，以联合最小二乘法求得，非该规范条款规定的计算方法",
    "Models (1) and (2) of {}, fitted jointly by least squares, which is not the computation of "
    "its clauses",
)
FITTED_WITH_DEVIATIONS = (
    f"{FITTED[0]}；有偏离，见“说明”",
    f"{FITTED[1]}; with deviations, see Remarks",
)
BASIS = {
    "jjf2003": (FOLLOWED, DEVIATED),
    "joint": (FITTED, FITTED_WITH_DEVIATIONS),
    "jjf1536": (FOLLOWED, DEVIATED),
}
SPECIFICATION_TITLES = {
    "JJF 2003-2022": (
        "JJF 2003—2022《微惯性测量组合（MIMU）校准规范》",
        "JJF 2003-2022, Calibration Specification for Micro Inertial Measurement Units (MIMU)",
    ),
    "JJF 1536-2015": (
        "JJF 1536—2015《捷联式惯性航姿仪校准规范》",
        "JJF 1536-2015, Calibration Specification for Strapdown Inertial Flight Attitudes",
    ),
}
TABLES = {"JJF 2003-2022": ("表 2 ", "Table 2"), "JJF 1536-2015": ("第 7 章", "clause 7")}

ROUNDING = (
    "U 为扩展不确定度，U = k·u，包含因子 k 列于各项标题。u 先修约至三位有效数字，U 按 JJF 1059.1 "
    "取两位有效数字，只进不舍；测得值修约至与 U 相同的末位。",
    "U is the expanded uncertainty, U = k·u; the coverage factor k stands in the heading of each "
    "item. u is rounded to three significant digits first; by JJF 1059.1, U has two and is rounded "
    "up; the value is rounded to the same last place.",
)
CONTENTS_OF_U = {
    "type A": (
        "本证书的不确定度仅为 A 类评定，由本次运行数据的分散性得到。"
        "转台、参考标准和数据采集系统引入的分量未包含在内；"
        "在加入这些分量之前，U 不是完整的测量不确定度。",
        "The uncertainties of this certificate are type A only, evaluated from the scatter of "
        "this run. The contributions of the turntable, the reference standards and the data "
        "acquisition are not in it; until they are added, U is not the complete uncertainty of "
        "measurement.",
    ),
    "GUM": (
        "不确定度按 JJF 1059.1（GUM）的不确定度传播律评定：A 类由本次运行数据得到（计及自相关），"
        "B 类由校准装置的极限得到。",
        "The uncertainties follow the law of propagation (GUM, JJF 1059.1): type A from the data "
        "of this run, with their autocorrelation, and type B from the limits of the equipment.",
    ),
    "as the specification's example": (
        "不确定度按本规范附录 A 的示例评定：u1（转台）、u2（数据采集）与 u3（重复性，线性相加）"
        "按方和根合成。",
        "The uncertainties are evaluated as in the examples of Appendix A: u1 (table), u2 (data "
        "acquisition) and u3 (repeatability, added linearly), in quadrature.",
    ),
    "Monte Carlo": (
        "不确定度按 JJF 1059.2（蒙特卡洛法）评定：各输入量的分布经各项的计算式传播；"
        "A 类由本次运行数据得到（计及自相关），B 类取自校准装置的技术指标；"
        "U 不小于包含区间的半宽。",
        "The uncertainties follow from the propagation of distributions by Monte Carlo (JCGM 101, "
        "JJF 1059.2) through the equation of each item: type A from the data of this run, with "
        "their autocorrelation, and type B from the limits of the equipment; U is not less than "
        "half the coverage interval.",
    ),
}
CONTENTS_IN_SHORT = {
    "type A": ("U 仅含 A 类评定的分量", "U contains type A only"),
    "GUM": ("U 含 A 类与 B 类分量（GUM）", "U contains type A and type B (GUM)"),
    "as the specification's example": (
        "U 按规范附录 A 示例评定",
        "U is evaluated as in the specification's Appendix A",
    ),
    "Monte Carlo": (
        "U 含 A 类与 B 类分量（蒙特卡洛法），包含概率不低于 95 %",
        "U contains type A and type B (Monte Carlo), coverage probability 95 % or more",
    ),
}
COVERAGE = (
    "k = {k:g}，正态分布时包含概率约 {percent:.0f} %",
    "k = {k:g}, about {percent:.0f} % coverage probability for a normal distribution",
)
COVERAGE_BY_T = (
    "k = 2 … {k:g}，包含概率约 95 %（有效自由度小于 50 时按 t 分布取 k）",
    "k = 2 to {k:g}, about 95 % coverage probability (k by Student's t where an element has fewer "
    "than 50 effective degrees of freedom)",
)
BLOCKS = ("本条影响判定：不得判为合格。", "This prevents a pass.")
SEE_REMARKS = (
    "“说明”中标有“影响判定”的 {} 条。",
    "The remarks below that prevent a pass: {}.",
)
UNREGISTERED = ("此标识未在册", "this identifier is not in the register")


def determined(item: Item | None) -> bool:
    """Whether an item has at least one value."""
    return item is not None and any(value is not None for value in item.value.values())


def deviates(calibration: Calibration) -> bool:
    """Whether a condition of the specification was not met."""
    return any(remark.blocks_pass for remark in calibration.remarks)


def basis(calibration: Calibration, specification: str) -> tuple[Pair, ...]:
    """Which clauses the values follow, whether to the letter, and which items have none."""
    values = [item for item in calibration.items.values() if determined(item)]
    clauses = sorted({clause(item.clause, specification) for item in values} - {("", "")})
    title = SPECIFICATION_TITLES[specification]
    zh, en = (
        form.format(name)
        for form, name in zip(BASIS[calibration.method][deviates(calibration)], title, strict=True)
    )
    if clauses:
        zh += f"；条款 {'、'.join(zh for zh, _ in clauses)}"
        en += f"; clauses {', '.join(en for _, en in clauses)}"
    said = [(f"{zh}。", f"{en}.")] if values else []
    absent = [
        item_name(name)
        for name in TABLE_ITEMS[specification]
        if not determined(calibration.items.get(name))
    ]
    if absent:
        (table_zh, table_en), (zh, en) = TABLES[specification], listed(absent)
        said.append(
            (f"{table_zh}中未得出结果的项目：{zh}。", f"Items of {table_en} not determined: {en}.")
        )
    return tuple(said)


def head_of_results(calibration: Calibration) -> Pair | None:
    """What U contains and which coverage probability goes with k; None without a value."""
    values = [item for item in calibration.items.values() if determined(item)]
    kinds = dict.fromkeys(CONTENTS_IN_SHORT[item.uncertainty_kind] for item in values)
    if not values:
        return None
    said = [*kinds, *_coverages(values)]
    return "；".join(zh for zh, _ in said) + "。", "; ".join(en for _, en in said) + "."


def _coverages(values: list[Item]) -> list[Pair]:
    """The coverage probability of k; by Student's t for budgets with few degrees of freedom."""
    largest = max(item.k for item in values)
    if all(item.uncertainty_kind == "Monte Carlo" for item in values):
        return [(f"k ≤ {largest:g}", f"k up to {largest:g}")]
    if largest > USUAL_K and all(item.uncertainty_kind == "GUM" for item in values):
        zh, en = COVERAGE_BY_T
        return [(zh.format(k=largest), en.format(k=largest))]
    return [_coverage(k) for k in dict.fromkeys(item.k for item in values)]


def _coverage(k: float) -> Pair:
    percent = 100 * math.erf(k / math.sqrt(2))
    return COVERAGE[0].format(k=k, percent=percent), COVERAGE[1].format(k=k, percent=percent)


def uncertainty(calibration: Calibration) -> tuple[Pair, ...]:
    """What U is, how it was rounded, and what is not in it."""
    kinds = dict.fromkeys(item.uncertainty_kind for item in calibration.items.values())
    return (ROUNDING, *(CONTENTS_OF_U[kind] for kind in kinds), *whose_limits(calibration))


def reasons(calibration: Calibration, decision: Decision) -> tuple[Pair, ...]:
    """Why a unit does not pass; the remarks that stand below anyway are only counted."""
    padded = (*decision.reasons_zh, *[""] * (len(decision.reasons) - len(decision.reasons_zh)))
    blocking = {remark.en for remark in calibration.remarks if remark.blocks_pass}
    own = [
        pair(*given(zh, en))
        for zh, en in zip(padded, decision.reasons, strict=False)
        if en not in blocking
    ]
    if blocking:
        count = sum(remark.blocks_pass for remark in calibration.remarks)
        own.append((SEE_REMARKS[0].format(count), SEE_REMARKS[1].format(count)))
    return tuple(own)


def identifiers(calibration: Calibration) -> dict[str, str]:
    """The readings that the values rest on, in order of appearance, and their names R1, R2 …"""
    values = (item for item in calibration.items.values() if determined(item))
    every = (reading for item in values for reading in item.readings)
    return {reading: f"R{n}" for n, reading in enumerate(dict.fromkeys(every), start=1)}


def readings(calibration: Calibration) -> tuple[tuple[str, Pair, Pair], ...]:
    """How the specification was read where it is wrong or silent: R1, the clause, the reading."""
    from tasks.specifications.readings import READINGS

    rows = []
    for identifier, short in identifiers(calibration).items():
        known = READINGS.get(identifier)
        said = pair_of(known.text) if known else UNREGISTERED
        rows.append((short, clause(known.clause) if known else (identifier,) * 2, said))
    return tuple(rows)


def remarks(calibration: Calibration) -> tuple[Pair, ...]:
    """What the reader has to know about this calibration, with the segments it is about."""
    return tuple(map(_remark, calibration.remarks))


def _remark(remark: Remark) -> Pair:
    """The remark; its segments where the sentence does not name them, and what it prevents."""
    zh, en = pair(remark.zh, remark.en)
    if not all(
        re.search(rf"(?<!\w){re.escape(name)}(?!\w)", remark.en) for name in remark.segments
    ):
        where = f" [{', '.join(remark.segments)}]"
        zh, en = zh + where, en + where
    return (zh + BLOCKS[0], f"{en} {BLOCKS[1]}") if remark.blocks_pass else (zh, en)
