"""Text for people: messages of the catalogues, and the words that were made of them.

A result keeps what it says as a message and, because its readers have no catalogues, in words as
`tasks.words` fills them. The contracts name two languages; a further one is a further field of the
same object. Also the validity of a run, which remarks decide before the verdict on the unit.
"""

import base64
import binascii
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Annotated, Any, Literal, Self, Union, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer, model_validator

from schemas.base import Frozen

RunVerdict = Literal["valid", "remarks", "invalid"]
# A language by its code: one that has a folder of catalogues.
Language = Annotated[str, Field(pattern="^[a-z]{2,8}(-[A-Za-z0-9]{2,8})*$")]
RUN_VERDICTS: tuple[RunVerdict, ...] = get_args(RunVerdict)  # the worst last

Sayable = Union["Message", "Statement", str]
Argument = Union[Sayable, int, tuple[Sayable | int, ...]]  # noqa: UP007 (names that come later)
# In JSON an object, by name.
Arguments = Annotated[
    tuple[tuple[str, Argument], ...],
    BeforeValidator(lambda given: tuple(given.items()) if isinstance(given, dict) else given),
    PlainSerializer(dict, return_type=dict[str, Argument], when_used="json"),
]


@dataclass(frozen=True)
class Message:
    """A sentence of the catalogues, by its identifier, and its named arguments.

    Measured numbers are given as text, rounded where they are made; whole numbers as numbers, so
    that a catalogue can choose singular or plural. A message or a statement inside a message is
    rendered in the same language, a tuple of them as a list.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")  # not that of the model it is a field of

    id: str
    arguments: Arguments = ()


AnyMessage = Annotated[Message | None, Field(exclude_if=lambda message: message is None)]
Messages = Annotated[
    tuple[Message | None, ...], Field(exclude_if=lambda messages: not any(messages))
]


class Wording(Frozen):
    """A name, a sentence or a paragraph in words, in each language by its code."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, str] = Field(init=False)

    en: str
    zh: str

    @property
    def words(self) -> dict[str, str]:
        """The words by language."""
        return {each: getattr(self, each) for each in CONTRACTED} | (self.__pydantic_extra__ or {})

    @property
    def pair(self) -> tuple[str, str]:
        """The words in the languages of the contracts."""
        return self.en, self.zh


# The languages that the contracts name: the main one, and that of the specifications.
CONTRACTED = tuple(Wording.model_fields)


class Statement(Wording):
    """What the program says, in words, and the message that these were made of, which can be
    rendered in any other language; null for a text of the user.
    """

    message: AnyMessage = None


PARTS = (*CONTRACTED, "message")
BOTH = "both"  # of them on one certificate, that of the specifications first


class Remark(Statement):
    """Something the reader of a result must know.

    `blocks_pass`: a condition of the specification is not met, so no unit may pass. `run`: its
    consequence for the validity of the run.
    """

    code: str
    segments: tuple[str, ...] = ()
    blocks_pass: bool = False
    run: RunVerdict = "valid"


@dataclass(frozen=True)
class Seen:
    """What a reader saw in a file beside its numbers, for `tasks.readings` to say: a code, its
    message, the segments that it holds for, and its consequence for the run.
    """

    code: str
    message: Message
    segments: tuple[str, ...] = ()
    run: RunVerdict = "remarks"


def text_fields(name: str, text: Statement, parts: Sequence[str] = PARTS) -> dict[str, Any]:
    """A text as the fields of a model: `name` in the main language, `name_…` in the other that the
    contracts name, `name_message`.
    """
    return {_field(name, part): getattr(text, part) for part in parts}


def no_text(name: str) -> dict[str, None]:
    """The fields of a model that has no such text."""
    return dict.fromkeys(_field(name, part) for part in CONTRACTED)


def texts_fields(name: str, texts: tuple[Statement, ...]) -> dict[str, Any]:
    """Several texts as such fields, a tuple each."""
    return {_field(name, part): tuple(getattr(text, part) for text in texts) for part in PARTS}


def text_of(model: BaseModel, name: str) -> Statement | None:
    """The text that a model has in such fields; None where it has none."""
    *words, message = (getattr(model, _field(name, part), None) for part in PARTS)
    return text_in(words, message)


def texts_of(model: BaseModel, name: str) -> tuple[Statement, ...]:
    """The texts that a model has in such fields, a tuple each."""
    columns = (getattr(model, _field(name, part)) for part in PARTS)
    rows = (text_in(words, message) for *words, message in zip_longest(*columns))
    return tuple(filter(None, rows))


def text_in(words: Sequence[str | None], message: Message | None = None) -> Statement | None:
    """A text by its words in the languages of the contracts, as far as they are given: one for
    every language where only one is; None where none is.
    """
    stated = [each if each and each.strip() else None for each in words]
    usual = next(filter(None, stated), None)
    if usual is None:
        return None
    filled: dict[str, Any] = {name: each or usual for name, each in zip_longest(CONTRACTED, stated)}
    return Statement(**filled, message=message)


def _field(name: str, part: str) -> str:
    return name if part == CONTRACTED[0] else f"{name}_{part}"


class Validity(Frozen):
    """Whether a run can be relied on, and every reason why not.

    remarks: something is unknown, or not as the specification requires; the values stand, but no
    unit passes. invalid: no value of the run supports a verdict on the unit.
    """

    verdict: RunVerdict = "valid"
    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
    reasons_message: Messages = ()


# What a laboratory's certificates look like: its logo, its seal, its wording, its own layout.


class Appearance(Frozen):
    """The content of the laboratory's files, so that the same record gives the same pages anywhere.

    logo, seal: pictures (SVG, PNG, JPEG) as base64. template: Typst source that replaces
    tasks/certificate/certificate.typ; it may import only the files beside that one.
    """

    logo: str | None = None
    seal: str | None = None
    template: str | None = None

    @property
    def pictures(self) -> dict[str, bytes]:
        """Logo and seal by name, where given."""
        both = {"logo": self.logo, "seal": self.seal}
        return {name: base64.b64decode(text) for name, text in both.items() if text}

    @model_validator(mode="after")
    def _readable(self) -> Self:
        for name, text in (("logo", self.logo), ("seal", self.seal)):
            try:
                base64.b64decode(text or "", validate=True)
            except binascii.Error as error:
                raise ValueError(f"{name} is not base64") from error
        if self.template and '"@' in self.template:
            raise ValueError('the template imports a package ("@…"); copy what it needs into it')
        return self
