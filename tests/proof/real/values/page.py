"""The page of values: one row for each parameter of each named finding."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from tests.proof.real.values.by_hand import ByHand, Key

COVERAGE = 2.0
Holds = Literal["yes", "both", "no", "—"]
IN = {"rad": ("deg", 57.29578), "m": ("mm", 1e3), "s": ("ms", 1e3)}


@dataclass(frozen=True)
class Row:
    """A parameter that explain states. holds: its U holds the value by hand; both: only with the
    U of that value.
    """

    recording: str
    effect: str
    parameter: str
    stated: str
    hand: str
    how: str
    holds: Holds


@dataclass(frozen=True)
class Explained:
    """An answer (`run.explained`), and what is known by hand, here and by others."""

    name: str
    answer: Mapping[str, Any]
    hand: Mapping[Key, ByHand]
    others: Mapping[Key, ByHand] = field(default_factory=dict)

    def rows(self) -> list[Row]:
        """Beside the values by hand."""
        return self._beside(self.hand)

    def rows_by_others(self) -> list[Row]:
        """Those that others measured."""
        return [row for row in self._beside(self.others) if row.holds != "—"]

    def _beside(self, hand: Mapping[Key, ByHand]) -> list[Row]:
        found = []
        for finding in self.answer.get("findings", ()):
            if finding["effect"] == "unnamed":
                continue
            found += [self._row(finding, each, hand) for each in finding["parameters"]]
        return found

    def _row(
        self, finding: Mapping[str, Any], each: Mapping[str, Any], known: Mapping[Key, ByHand]
    ) -> Row:
        effect, parameter = finding["effect"], each["name"]
        names = (effect, *finding.get("group", ()))
        hand = next(
            (known[n, parameter] for n in names if (n, parameter) in known), None
        )  # fmt: skip
        unit, times = IN.get(each["unit"], (each["unit"], 1.0))
        value, U = times * each["value"], times * COVERAGE * each["u"]
        stated = f"{value:.5g} ± {U:.2g} {unit}"
        name = effect if len(names) == 1 else f"{effect} (or {', '.join(names[1:])})"
        if hand is None:
            return Row(self.name, name, parameter, stated, "—", "—", "—")
        own, expanded = times * hand.value.value, times * COVERAGE * hand.value.u
        off = abs(value - own)
        holds: Holds = "yes" if off <= U + 1e-9 * abs(own) else "no"
        if holds == "no" and off <= (U**2 + expanded**2) ** 0.5:
            holds = "both"
        return Row(
            self.name, name, parameter, stated, f"{own:.5g} ± {expanded:.2g}", hand.how, holds
        )


def markdown(every: Sequence[Explained], code_version: str) -> str:
    """Counts first, then all rows, then the recordings without a name."""
    rows = [row for one in every for row in one.rows()]
    others = [row for one in every for row in one.rows_by_others()]
    judged = [row for row in rows if row.holds != "—"]
    findings: dict[tuple[str, str], set[Holds]] = {}
    for row in judged:
        findings.setdefault((row.recording, row.effect), set()).add(row.holds)
    alone = sum(held == {"yes"} for held in findings.values())
    both = sum("no" not in held for held in findings.values())
    lines = [
        "# Values on every real recording", "",
        "Each parameter of each named finding of `explain` with U (k = 2), beside the value by "
        "hand with its own U: an independent fit (`tests/proof/real/hand`), or what the "
        "recording's origin documents. A finding holds where all of its parameters do: by its U "
        "alone (yes), or with that of the value by hand (both).", "",
        f"{len(findings)} findings have a value by hand: {alone} hold by their U alone, {both} "
        f"with that by hand. Of {len(judged)} parameters {sum(r.holds == 'yes' for r in judged)} "
        f"and {sum(r.holds != 'no' for r in judged)}. {len(rows) - len(judged)} stated parameters "
        "have none by hand.", "",
        *_table(rows), "",
        "## Beside what others measured", "",
        "By hand by those who brought the recordings, before and without the fits above: "
        f"{sum(r.holds == 'yes' for r in others)} of {len(others)} parameters hold by their U "
        f"alone, {sum(r.holds != 'no' for r in others)} with that by hand where one is stated.",
        "", *_table(others), "",
        "## Verdicts", "",
        "| recording | verdict | explained | without a name, or refused |", "|---|---|---:|---|",
        *(_verdict(one) for one in every), "", f"{code_version}.", "",
    ]  # fmt: skip
    return "\n".join(lines)


def _table(rows: Sequence[Row]) -> list[str]:
    return [
        "| recording | effect | parameter | value ± U | by hand ± U | by hand, how | holds |",
        "|---|---|---|---:|---:|---|---|",
        *(f"| {r.recording} | {r.effect} | {r.parameter} | {r.stated} | {r.hand} | {r.how} | "
          f"{r.holds} |" for r in rows),
    ]  # fmt: skip


def _verdict(one: Explained) -> str:
    answer = one.answer
    if "refused" in answer:
        return f"| {one.name} | not explained: {answer['refused']} | | |"
    unnamed = [
        each["behaviour"] + (f" (refused: {each['refused']})" if each["refused"] else "")
        for each in answer["findings"] if each["effect"] == "unnamed"
    ]  # fmt: skip
    share = f"{100.0 * answer['explained_share']:.0f} %"
    return f"| {one.name} | {answer['verdict']} | {share} | {'; '.join(unnamed) or '—'} |"
