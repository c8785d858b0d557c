"""What an amendment prints of its difference from the certificate that it replaces."""

from schemas.certificate import Replaced
from tasks.words import Message, message


def changes(replaced: Replaced | None) -> tuple[Message, ...]:
    """A sentence for everything that is different (ISO/IEC 17025:2017, 7.8.8.2)."""
    if replaced is None:
        return ()
    if not replaced.changes:
        return (message("certificate-changed.nothing", number=replaced.number),)
    return tuple(
        message(
            "certificate-changed", number=replaced.number,
            what=each.what, before=each.before, after=each.after,
        )
        for each in replaced.changes
    )  # fmt: skip
