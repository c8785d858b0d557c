"""Stage: a sentence to whoever operates the line, by the channels of recall.toml."""

from collections.abc import Collection
from dataclasses import dataclass

from schemas.base import Unusable
from storage import settings
from storage.home import Home
from tasks.reminders import send as sending
from tasks.stages.events import logger_of
from tasks.stages.remind import Send
from tasks.words import Sayable, message, say

LOG = logger_of("alert")


@dataclass(frozen=True)
class Sent:
    """The outcome of an alert on a channel; fault: why it was not delivered, None if it was."""

    channel: str
    fault: str | None


def alert(
    home: Home,
    sentence: Sayable,
    send: Send = sending.send,
    *,
    only: Collection[str] | None = None,
) -> list[Sent]:
    """Sends a sentence to the operators on each of their channels, in silent hours too.

    only: the channels, by name, in the place of all.

    Raises Unusable where recall.toml names no operators, and for an invalid channel.
    """
    asked = settings.reminders(home)
    if asked is None or asked.operators is None:
        raise Unusable(
            f"{home.path / settings.REMINDERS} names no operators; add [operators] with channels."
        )
    urls = {
        name: sending.check_channel(name, url)
        for name, url in asked.operators.channels.items()
        if only is None or name in only
    }
    language = asked.operators.language
    title, sentence = say(message("alert-title"), language), say(sentence, language)
    done = [Sent(name, send(url, title, sentence, None)) for name, url in urls.items()]
    for each in done:
        fields = {"of": sentence, "channel": each.channel, "cause": each.fault}
        LOG.warning("failed" if each.fault else "sent", extra=fields)
    return done
