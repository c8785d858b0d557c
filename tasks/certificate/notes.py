"""The sentences of the certificate: basis, uncertainty, readings taken, remarks."""

from schemas.calibration import Calibration
from tasks.certificate.names import Pair

BASIS = {
    "jjf2003": (
        "本次校准依据 JJF 2003—2022《微惯性测量组合（MIMU）校准规范》，条款 {clauses}。",
        "Calibrated according to JJF 2003-2022, Calibration Specification for Micro Inertial "
        "Measurement Units (MIMU), clauses {clauses}.",
    ),
    "joint": (
        "参照 JJF 2003—2022《微惯性测量组合（MIMU）校准规范》的模型式(1)、(2)，"
        "以联合最小二乘法求得，非该规范条款规定的计算方法（对应条款 {clauses}）。",
        "Models (1) and (2) of JJF 2003-2022, Calibration Specification for Micro Inertial "
        "Measurement Units (MIMU), fitted jointly by least squares. This is not the computation "
        "of its clauses (items correspond to {clauses}).",
    ),
    "jjf1536": (
        "本次校准依据 JJF 1536—2015《捷联式惯性航姿仪校准规范》，条款 {clauses}。",
        "Calibrated according to JJF 1536-2015, Calibration Specification for Strapdown "
        "Inertial Flight Attitudes, clauses {clauses}.",
    ),
}

ROUNDING = (
    "U 为扩展不确定度，U = k·u，包含因子 k 列于各项标题。U 按 JJF 1059.1 取两位有效数字，只进不舍；"
    "测得值修约至与 U 相同的末位。",
    "U is the expanded uncertainty, U = k·u; the coverage factor k stands in the heading of each "
    "item. By JJF 1059.1, U has two significant digits and is rounded up; the value is rounded to "
    "the same last place.",
)
CONTENTS_OF_U = {
    "type A": (
        "本证书的不确定度仅为 A 类评定（type A），由本次运行数据的分散性得到。"
        "转台、参考标准和数据采集系统引入的分量未包含在内；"
        "在加入这些分量之前，U 不是完整的测量不确定度。",
        "The uncertainties of this certificate are type A only, evaluated from the scatter of "
        "this run. The contributions of the turntable, the reference standards and the data "
        "acquisition are not in it; until they are added, U is not the complete uncertainty of "
        "measurement.",
    ),
}
BLOCKS = ("本条影响判定：不得判为合格。", "This prevents a pass.")
UNREGISTERED = ("此标识未在册", "this identifier is not in the register")


def basis(calibration: Calibration, specification: str) -> Pair:
    """Which specification and which of its clauses the results follow."""
    zh, en = BASIS[calibration.method]
    found = (item.clause.removeprefix(specification) for item in calibration.items.values())
    clauses = ", ".join(sorted({clause.strip(" ,") for clause in found} - {""})) or "—"
    return zh.format(clauses=clauses), en.format(clauses=clauses)


def uncertainty(calibration: Calibration) -> tuple[Pair, ...]:
    """What U is, how it was rounded, and what is not in it."""
    kinds = dict.fromkeys(item.uncertainty_kind for item in calibration.items.values())
    return (ROUNDING, *(CONTENTS_OF_U[kind] for kind in kinds))


def identifiers(calibration: Calibration) -> dict[str, str]:
    """The readings taken, in order of appearance, and the short names R1, R2 … they get."""
    every = (reading for item in calibration.items.values() for reading in item.readings)
    return {reading: f"R{n}" for n, reading in enumerate(dict.fromkeys(every), start=1)}


def readings(calibration: Calibration) -> tuple[tuple[str, str, Pair], ...]:
    """How the specification was read where it is wrong or silent: R1, the clause, the reading."""
    from tasks.items.readings import READINGS

    rows = []
    for identifier, short in identifiers(calibration).items():
        known = READINGS.get(identifier)
        said = (known.zh, known.en) if known else UNREGISTERED
        rows.append((short, known.clause if known else identifier, said))
    return tuple(rows)


def remarks(calibration: Calibration) -> tuple[Pair, ...]:
    """What the reader has to know about this calibration, with the segments it is about."""
    rows = []
    for remark in calibration.remarks:
        where = f" [{', '.join(remark.segments)}]" if remark.segments else ""
        zh, en = BLOCKS if remark.blocks_pass else ("", "")
        rows.append((f"{remark.zh}{where}{zh}", f"{remark.en}{where} {en}".rstrip()))
    return tuple(rows)
