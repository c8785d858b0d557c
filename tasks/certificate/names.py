"""Items, units, rules and verdicts as they are printed, in both languages."""

from schemas.tolerance import Decision, LimitDecision
from tasks.specifications.items import ITEMS
from tasks.words import Message, say

Pair = tuple[str, str]  # Chinese, English

QUANTITIES = {
    "value": ("条款给出的值", "the value by the clause"),
    "value_without_earth_rotation": (
        "扣除地球自转后的值",
        "the value with Earth's rotation removed",
    ),
    "value_model": ("符号按模型式(2)的值", "the value with the sign of model (2)"),
}

# {w}, {zh} and {en} stand for the guard band and its side: tasks.certificate.decisions.
RULES = {
    "simple_acceptance": (
        "简单接受（JCGM 106，8.2）：测得值在允许限内即为符合，不另留保护带（w = 0）",
        "simple acceptance (JCGM 106, 8.2): a measured value inside its limits conforms, without "
        "a guard band (w = 0)",
    ),
    "guard_band": (
        "保护带判定（JCGM 106，8.3）：测得值在接受限 AL 内方为符合，接受限由允许限{zh}移 w = {w}",
        "guard band (JCGM 106, 8.3): a measured value inside its acceptance limits AL conforms; "
        "they lie {en} the limits by w = {w}",
    ),
    "shared_risk": (
        "风险共担（JCGM 106，8.2）：按双方约定，测得值在允许限内即为符合（w = 0）",
        "shared risk (JCGM 106, 8.2): as both parties agreed, a measured value inside its limits "
        "conforms (w = 0)",
    ),
}

KINDS = {
    "type A": ("A 类评定", "type A"),
    "GUM": ("GUM 法，A 类与 B 类合成", "GUM, type A and B combined"),
    "as the specification's example": ("按规范附录 A 示例", "as Appendix A of the specification"),
    "Monte Carlo": ("蒙特卡洛法，A 类与 B 类合成", "Monte Carlo, type A and B combined"),
}

VERDICTS = {
    "pass": ("合格", "pass"),
    "fail": ("不合格", "fail"),
    "inconclusive": ("无法判定", "inconclusive"),
}
# Within U of a limit; the names are those of ILAC-G8:09/2019, 4.2.3.
CONDITIONAL = {
    "pass": ("有条件合格", "conditional pass"),
    "fail": ("有条件不合格", "conditional fail"),
}


def item_name(item: str) -> Pair:
    """The name of an item, Chinese and English; its key where it is not of a specification."""
    return pair_of(ITEMS[item].title) if item in ITEMS else (item, item)


def pair_of(text: Message) -> Pair:
    """A message in Chinese and English."""
    return say(text, "zh"), say(text, "en")


def verdict_words(decided: Decision | LimitDecision) -> Pair:
    """A verdict in words, with its condition where a value lies within U of a limit."""
    return (CONDITIONAL if decided.marginal else VERDICTS)[decided.verdict]


def symbol(item: str, element: str) -> str:
    """The symbol of an element as plain text, like K_gxx; the element where there is none."""
    return ITEMS[item].symbol(element) if item in ITEMS else element
