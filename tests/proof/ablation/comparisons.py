"""The rules and constants of confounding that are switched off, as data."""

from collections.abc import Iterable, Sequence
from typing import Any

from tests.proof.ablation.switch import Switch
from tests.proof.ablation.switches import first, says, second

C, L = "confounding.compare", "confounding.linear_forms"
FAMILY, FORMS = f"{C}:_Family", f"{L}:LinearForms"
COMPARED = f"{C}:compared"


def _cheapest(self: Any, tried: Sequence[Any]) -> Any:
    return min(tried, key=self._cost)


def _all_near(chosen: Any, near: Iterable[Any], *rest: Any) -> list[Any]:
    return list(near)


def _only_clipped(group: Any, *rest: Any) -> tuple[str, ...]:
    return ()


COMPARISONS = (
    Switch("comparing", "combinations of what compensates", "explain:compared", first),
    Switch("bootstrap of the reference", "may be the truth though it fits worse",
           "confounding.bootstrap:ReferenceBootstrap.rivals", says(())),
    Switch("play", "tips from side to side, not bends", "explain:with_play", first),
    Switch("special case fits better", "lever arm in place of size effect",
           f"{FAMILY}._special_case", second),
    Switch("general beside special", "size effect beside a lever arm",
           f"{C}:with_general", _all_near),
    Switch("hidden in", "another may make up for a tenth", f"{FAMILY}._hidden_in", says(False)),
    Switch("fewest effects", "before what fits best", f"{FAMILY}._fewest_effects", _cheapest),
    Switch("pruned combinations", "what only made up for it",
           f"{FAMILY}._pruned", lambda self, tried: list(tried)),
    Switch("delay with filter", "both at once", f"{FAMILY}._delay_with_filter", says([])),
    Switch("promising pairs", "a second effect beside", f"{FAMILY}._promising", says(())),
    Switch("smooths", "a filter beside a delay promises more", f"{FAMILY}._smooths", says(False)),
    Switch("cancelled", "a lead that cancels a low-pass",
           "confounding.combinations:Combination.is_cancelled", says(False)),
    Switch("plausible", "within the range of a working unit",
           "confounding.combinations:Combination.plausible", says(True)),
    Switch("plausible alone", "in place of what is not", f"{FAMILY}._plausible_alone", says([])),
    Switch("holds", "what linear forms prefer fits better", f"{FAMILY}._holds", says(True)),
    Switch("rivals of nuisances", "what fits as well as the delay",
           f"{FAMILY}.with_rivals", lambda self: self.fit),
    Switch("THERMOMETER", "temperature known no better",
           f"{L}:THERMOMETER", 0.0, f"{FORMS}.indistinguishable"),
    Switch("FORM of linear forms", "error of their form",
           f"{L}:FORM", 0.0, f"{FORMS}.distinguishable"),
    Switch("triads differ", "delays of each triad's own", f"{FORMS}.triads_differ", says(False)),
    Switch("rivals of the search", "names that fit as well in its place",
           "evidence.findings:_indistinguishable", _only_clipped),
    Switch("resolved", "blocks half as long", "search.fitted:Searched.resolved", second),
)  # fmt: skip
