"""Messages for people: named arguments, and catalogues in every language.

The numerics say *what* (`message("validity-stuck", channel="gyro_x")`); the sentences stand in
`LANGUAGE/*.ftl` (Project Fluent), a file for each room, so that a metrologist can read the Chinese
in one place. A further language is a further folder.
"""

from tasks.words.message import Argument, Message, Sayable, argument, clauses, kind_of, message
from tasks.words.translation import (
    LANGUAGES,
    MAIN,
    cause_of,
    identifiers,
    known,
    remark,
    say,
    statement,
    texts,
    worded,
)

__all__ = [
    "LANGUAGES",
    "MAIN",
    "Argument",
    "Message",
    "Sayable",
    "argument",
    "cause_of",
    "clauses",
    "identifiers",
    "kind_of",
    "known",
    "message",
    "remark",
    "say",
    "statement",
    "texts",
    "worded",
]
