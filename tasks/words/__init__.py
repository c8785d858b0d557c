"""Messages for people: named arguments, and catalogues in every language.

The numerics say *what* (`message("validity-stuck", channel="gyro_x")`); the sentences stand in
`en/*.ftl` and `zh/*.ftl` (Project Fluent), a file for each room, so that a metrologist can read
the Chinese in one place. A further language is a further folder.
"""

from tasks.words.message import Argument, Message, Sayable, clauses, message
from tasks.words.translation import LANGUAGES, identifiers, known, remark, say, statement, texts

__all__ = [
    "LANGUAGES",
    "Argument",
    "Message",
    "Sayable",
    "clauses",
    "identifiers",
    "known",
    "message",
    "remark",
    "say",
    "statement",
    "texts",
]
