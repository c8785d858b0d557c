"""The rules and constants of confounding that are switched off, as data."""

from collections.abc import Sequence
from typing import Any

from tests.proof.ablation.switch import Switch
from tests.proof.ablation.switches import first, says, second

C, L = "confounding.compare", "confounding.linear_forms"
DELAYS, FORMS = f"{C}:_Delays", f"{L}:LinearForms"
COMPARED = f"{C}:compared"


def _cheapest(self: Any, tried: Sequence[Any]) -> Any:
    return min(tried, key=self._cost)


def _only_clipped(group: Any, *rest: Any) -> tuple[str, ...]:
    return ()


COMPARISONS = (
    Switch("comparing", "combinations of what compensates", "explain:compared", first),
    Switch("play", "tips from side to side, not bends", "explain:with_play", first),
    Switch("preferred", "special cases and plausible ones first", "explain:with_preferred", first),
    Switch("fewest effects", "before what fits best", f"{DELAYS}._fewest_effects", _cheapest),
    Switch("pruned combinations", "what only made up for it",
           f"{DELAYS}._pruned", lambda self, tried: list(tried)),
    Switch("delay with filter", "both at once", f"{DELAYS}._delay_with_filter", says([])),
    Switch("promising pairs", "a second effect beside", f"{DELAYS}._promising", says(())),
    Switch("smooths", "a filter beside a delay promises more", f"{DELAYS}._smooths", says(False)),
    Switch("cancelled", "a lead that cancels a low-pass",
           "confounding.combinations:Combination.is_cancelled", says(False)),
    Switch("plausible", "within the range of a working unit",
           "confounding.combinations:Combination.plausible", says(True)),
    Switch("rivals of nuisances", "what fits as well as the delay",
           f"{DELAYS}.with_rivals", lambda self: self.fit),
    Switch("FORM of linear forms", "error of their form",
           f"{L}:FORM", 0.0, f"{FORMS}.distinguishable"),
    Switch("triads differ", "delays of each triad's own", f"{FORMS}.triads_differ", says(False)),
    Switch("rivals of the search", "names that fit as well in its place",
           "evidence.findings:_indistinguishable", _only_clipped),
    Switch("resolved", "blocks half as long", "search.fitted:Searched.resolved", second),
)  # fmt: skip
