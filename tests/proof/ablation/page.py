"""What each rule moves, as a table."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tests.proof.ablation.counts import counts
from tests.proof.report import table

COLUMNS = (
    "rule", "what it is for", "recordings", "where it acts", "right names gained / lost without it",
    "wrong names gained / lost", "other groups", "other intervals",
    "intervals that hold the truth, with / without", "for example",
)  # fmt: skip
MOVED = 0.05  # of u: an interval that changes by less is the same
EXAMPLES = 3
Row = Mapping[str, Any]


@dataclass
class Counted:
    """What a switch moves, over recordings. inside: intervals that hold the truth, with and
    without the rule, and how many of each are stated.
    """

    asked: int = 0
    acted: int = 0
    right_gained: int = 0
    right_lost: int = 0
    wrong_gained: int = 0
    wrong_lost: int = 0
    groups: int = 0
    intervals: int = 0
    inside: tuple[int, int] = (0, 0)
    stated: tuple[int, int] = (0, 0)
    failed: int = 0
    examples: tuple[str, ...] = ()

    @property
    def moves(self) -> bool:
        return any((self.right_gained, self.right_lost, self.wrong_gained, self.wrong_lost,
                    self.groups, self.intervals, self.failed))  # fmt: skip


def counted(rows: Iterable[Row], name: str) -> Counted:
    """What a switch of this name moves."""
    total = Counted()
    for row in rows:
        if "failed" in row or name not in row["asked"]:
            continue
        total.asked += 1
        if name not in row["without"]:
            continue
        total.acted += 1
        _add(total, row, row["without"][name])
    return total


def _add(total: Counted, row: Row, other: Row) -> None:
    if "failed" in other:
        total.failed += 1
        return
    before, after = row["judged"], other.get("judged", row["judged"])
    gained = {say: Counter(after[say]) - Counter(before[say]) for say in ("right", "wrong")}
    lost = {say: Counter(before[say]) - Counter(after[say]) for say in ("right", "wrong")}
    total.right_gained += gained["right"].total()
    total.right_lost += lost["right"].total()
    total.wrong_gained += gained["wrong"].total()
    total.wrong_lost += lost["wrong"].total()
    answer = other.get("answer", row["answer"])
    total.groups += _groups(row["answer"]) != _groups(answer)
    total.intervals += not _same_intervals(row["answer"], answer)
    total.inside = total.inside[0] + before["inside"], total.inside[1] + after["inside"]
    total.stated = total.stated[0] + before["stated"], total.stated[1] + after["stated"]
    marks = [
        f"{sign}{name}{'!' if say == 'wrong' else ''}"
        for sign, by_say in (("+", gained), ("−", lost))
        for say, names in by_say.items()
        for name in names.elements()
    ]
    if marks and len(total.examples) < EXAMPLES:
        total.examples += (f"{row['kind']} {row['label']}: {', '.join(marks)}",)


def _groups(answer: Row) -> list[Any]:
    return sorted(
        (one["effect"], sorted(one["group"]), sorted(one["indistinguishable_from"]))
        for one in answer["findings"]
        if one["effect"] != "unnamed"
    )


def _same_intervals(one: Row, other: Row) -> bool:
    first, second = _intervals(one), _intervals(other)
    return all(
        abs(first[key][0] - second[key][0]) <= MOVED * first[key][1]
        and abs(first[key][1] - second[key][1]) <= MOVED * first[key][1]
        for key in first.keys() & second.keys()
    )


def _intervals(answer: Row) -> dict[tuple[str, str], tuple[float, float]]:
    return {
        (one["effect"], each["name"]): (each["value"], each["u"])
        for one in answer["findings"]
        if one["effect"] != "unnamed"
        for each in one["parameters"]
        if each["u"] > 0.0
    }


def markdown(rows: Sequence[Row], purposes: Mapping[str, str]) -> str:
    """The table, a row for each rule. purposes: of each, by its name."""
    size = counts()
    answered = [row for row in rows if "failed" not in row]
    kinds = Counter(row["kind"] for row in answered)
    names = Counter[str]()
    for row in answered:
        for say in ("right", "wrong"):
            names[say] += len(row["judged"][say])
    lines = [
        "# Each rule of `explain` switched off in turn", "",
        f"{len(answered)} recordings: {', '.join(f'{n} {kind}' for kind, n in kinds.items())}; "
        f"{len(rows) - len(answered)} could not be read. With all rules: {names['right']} right "
        f"names, {names['wrong']} wrong ones. A rule acts where any of its outcomes would differ "
        "without it; ! marks a wrong name.", "",
        f"The engine has {size.lines} lines without blanks, {size.constants} numeric constants of "
        f"modules and {size.names} literal names of effects outside of the files that find events, "
        f"in {size.files} files.", "",
        *table(COLUMNS, (
            (name, why, *_cells(counted(rows, name))) for name, why in purposes.items()
        )), "",
    ]  # fmt: skip
    return "\n".join(lines)


def _cells(each: Counted) -> list[str]:
    if not each.acted:
        moved = ["0", *["–"] * 6]
    else:
        moved = [
            f"{each.acted}" + (f", fails in {each.failed}" if each.failed else ""),
            f"{each.right_gained} / {each.right_lost}",
            f"{each.wrong_gained} / {each.wrong_lost}",
            f"{each.groups}",
            f"{each.intervals}",
            " / ".join(f"{a} of {b}" for a, b in zip(each.inside, each.stated, strict=True)),
            "; ".join(each.examples),
        ]
    return [f"{each.asked}", *moved]
