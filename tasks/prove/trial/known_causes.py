"""Why cases fail, as far as somebody has found out; the rest says so."""

from collections.abc import Mapping

from tasks.model.term import Text

# By what is true («clean» where nothing is) and what was said: a name, «unnamed» or «nothing».
KNOWN_CAUSES: Mapping[tuple[str, str], Text] = {}
NOT_KNOWN: Text = ("not looked into", "尚未查明")
FAINT: Text = (
    "too faint to be told among all the effects looked for",
    "信号过弱，同时搜索全部因素时无法分辨",
)
