"""How sentences from elsewhere are set: dashes, minus signs and equation numbers by language."""

import re

from tasks.certificate.names import Pair
from tasks.words.rounding import MINUS

_NUMBER = r"\((?:[A-Z]\.)?\d+\)"


def english(text: str) -> str:
    """Real minus signs, ° for deg, and en dashes between equation numbers."""
    text = re.sub(r"(?<![\w.)\]-])-(?=\d|[xyz]\b)", MINUS, text)
    text = re.sub(rf"(eq\. {_NUMBER})-(?={_NUMBER})", r"\1–", text)
    return re.sub(r"\bdeg/s\b", "°/s", text)


def chinese(text: str) -> str:
    """The same, with 式(3)～式(5), JJF 2003—2022 and ～ between two numbers."""
    text = english(text)
    text = re.sub(r"\b(JJF \d+)-(?=\d{4}\b)", r"\1—", text)
    text = re.sub(rf"eq\. ({_NUMBER})–({_NUMBER})", r"式\1～式\2", text)
    text = re.sub(rf"eq\. ({_NUMBER}(?:, {_NUMBER})*)", _equations, text)
    return re.sub(r"(?<=\d)~(?=[\d−])", "～", text)


def pair(zh: str, en: str) -> Pair:
    """A sentence of the program in both languages, set as each asks for it."""
    return chinese(zh), english(en)


def clause(text: str, specification: str = "") -> Pair:
    """A clause in both languages, without the name of the specification that is meant anyway."""
    short = text.removeprefix(specification).strip(" ,")
    zh = re.sub(r"list under (eq\. \(\d+\))", r"\1下列表", short)
    zh = re.sub(r"Appendix ([A-Z])(?:, (\d+))?", _appendix, zh)
    zh = re.sub(r"Table (\d)", r"表 \1", zh)
    zh = re.sub(r"(?<=\d) to (?=\d)", "～", zh)
    zh = re.sub(r"(?<=\)) and (?=eq\.)", "、", zh)
    zh = chinese(zh).replace(" and ", " 和 ")
    zh = zh.replace(", joint method with gravity alone", "（联合法，仅以重力为参考）")
    zh = zh.replace(", joint method", "（联合法）")
    return re.sub(r", (?=式)", " ", zh).replace(", ", "，"), english(short)


def _equations(found: re.Match[str]) -> str:
    return "、".join(f"式{number}" for number in found[1].split(", "))


def _appendix(found: re.Match[str]) -> str:
    return f"附录 {found[1]}" + (f" 第 {found[2]} 项" if found[2] else "")
