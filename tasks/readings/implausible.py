"""One thing that a recording cannot be."""

from dataclasses import dataclass

from tasks.words import Message

KINDS = ("time_unit", "gravity_removed", "force_unit", "rate_unit", "table_unit", "axes",
         "labels_shifted")  # fmt: skip


@dataclass(frozen=True)
class Implausible:
    """One thing that a recording cannot be.

    kind: its catalogue name. sentence: what is wrong, by how much and how to import it right.
    option: that of `mimucal import`, empty where none helps.
    """

    kind: str
    sentence: Message
    option: str = ""


def ratio_text(value: float) -> str:
    return f"{value:.4g}" if value > 1 else f"1/{1.0 / value:.4g}"
