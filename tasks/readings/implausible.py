"""What is found on sight: one remark for each thing, made once, and shown by all in its words."""

from schemas.text import Remark, RunVerdict
from tasks.words import Message, remark

# What makes everything else that a recording shows doubtful, and comes first.
KINDS = ("time_unit", "gravity_removed", "force_unit", "rate_unit", "table_unit", "label_unit",
         "axes", "mount", "column_exchanged", "column_copied", "labels_shifted",
         "rate_setting", "force_setting", "clock_set", "restarted", "no_data", "held_rows",
         "coarse_log")  # fmt: skip


def found_on_sight(
    kind: str, sentence: Message, segments: tuple[str, ...] = (), run: RunVerdict = "invalid"
) -> Remark:
    """kind: its catalogue name. sentence: what is wrong, by how much, and how to import it right or
    what to do; of an option that of `mimucal import`.
    """
    return remark(kind, sentence, segments, blocks_pass=run != "valid", run=run)


def ratio_text(value: float) -> str:
    return f"{value:.4g}" if value > 1 else f"1/{1.0 / value:.4g}"
