"""The page: how many recordings have a wrong name, with the bound that this sets to its rate."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from tasks.quality.yields import wilson

ORIGINAL, CLEAN = "original", "clean"
OF_KIND = {
    "flipped": "stretches of the residual with the other sign",
    "scrambled": "stretches of the residual in another order",
    CLEAN: "of the sealed trial, without effects, as they are",
}
METHOD = """\
A null recording is what the accepted model predicts of a real recording, with its own residual torn
out of its order: the fast part in stretches of 5 to 30 s, the channels of a triad together, the
slow part of each channel (a running median over 5 s) from one zero crossing to the next. Motion,
labels, temperatures and reference are those of the recording. Nothing is true in it but the
accepted model: a name is wrong where neither it nor one that it cannot be told from was found in
the original; small remainders count as well. What the accepted model has without reporting it under
a name (a withdrawn name; what every tracked body has) is in the null recording, and is counted
apart. A residual of few plateaus, as of a table with few rates, keeps them with other signs or in
another order, and an effect of its own may survive in them. Readings whose motion is unknown stay
as they were recorded; the others are rounded to the codes of the recording, which adds a twelfth of
a squared step to their variance. Null recordings of one original share its motion and the size of
its noise: the bound takes them as drawn independently."""
Row = Mapping[str, Any]


def markdown(rows: Sequence[Row], code: str) -> str:
    """The counts of each kind, what was named wrongly, and each real recording. code: its version.

    The bound is the upper one of the two-sided 95 % interval.
    """
    lines = ["# Wrong names by chance", "", f"mimucal {code}.", "", METHOD, ""]
    lines += _table(
        "kind", "recordings", "of so many originals", "with a wrong name", "rate, at most (95 %)",
        "with an unreported name of the model", "names of the original found again",
        "with something unnamed", "not explained",
    )  # fmt: skip
    for kind, what in (*OF_KIND.items(), ("all", "together")):
        some = [row for row in rows if row["kind"] in (kind, *(OF_KIND if kind == "all" else ()))]
        lines.append(_line(f"{kind}: {what}", *_cells(some)))
    lines += ["", "## Wrong names", ""]
    wrong = [row for row in rows if row["kind"] in OF_KIND and row.get("wrong")]
    if wrong:
        lines += _table("kind", "recording", "draw", "wrong", "true")
    lines += [_line(*_of(row), _names(row["wrong"]), _names(row["true"])) for row in wrong] or [
        "None."
    ]
    lines += ["", "## Each real recording", ""]
    lines += _table("recording", "found in the original", "null recordings", "wrong", "unreported")
    lines += [_line(*cells) for cells in _originals(rows)]
    return "\n".join(lines) + "\n"


def _cells(some: Sequence[Row]) -> Iterator[str]:
    answered = [row for row in some if "failed" not in row]
    wrong = sum(bool(row["wrong"]) for row in answered)
    yield str(len(answered))
    yield str(len({(row["label"], row["kind"] == CLEAN and row["draw"]) for row in answered}))
    yield str(wrong)
    yield f"{100.0 * upper_bound(wrong, len(answered)):.1f} %" if answered else "–"
    yield str(sum(bool(row["returned"]) for row in answered))
    again = [(name in row["names"]) for row in answered for name in row["found"]]
    yield f"{sum(again)} of {len(again)}"
    yield str(sum(bool(row["unnamed"]) for row in answered))
    yield str(len(some) - len(answered))


def upper_bound(wrong: int, of: int) -> float:
    """Of the rate, by Wilson's interval at 95 %."""
    return float(wilson(np.array([wrong]), np.array([of]))[1][0])


def _originals(rows: Sequence[Row]) -> Iterator[tuple[str, ...]]:
    for row in rows:
        if row["kind"] != ORIGINAL:
            continue
        nulls = [one for one in rows if one["label"] == row["label"] and "failed" not in one
                 and one["kind"] not in (ORIGINAL, CLEAN)]  # fmt: skip
        found = row.get("failed") or _names(row["names"])
        counts = (sum(bool(one[say]) for one in nulls) for say in ("wrong", "returned"))
        yield row["label"], found, str(len(nulls)), *map(str, counts)


def _of(row: Row) -> tuple[str, str, str]:
    return row["kind"], row["label"], str(row["draw"])


def _names(names: Sequence[str]) -> str:
    return ", ".join(names) or "–"


def _table(*columns: str) -> list[str]:
    return [_line(*columns), _line(*["---"] * len(columns))]


def _line(*cells: str) -> str:
    return "| " + " | ".join(cells) + " |"
