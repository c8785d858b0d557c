"""Sends a reminder by the URL of a channel: e-mail with a calendar entry, or a chat message."""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from string import Template

from schemas.base import Unusable

ENTRY = "recalibration.ics"
NO_REASON = "the channel gave no reason"


def check_channel(name: str, url: str) -> str:
    """The URL of a channel with environment variables filled in; Unusable for an invalid one."""
    from apprise import Apprise

    try:
        whole = Template(url).substitute(os.environ)
    except KeyError as missing:
        raise Unusable(
            f"recall.toml: channel {name!r} uses ${{{missing.args[0]}}}, which is not set in "
            "the environment; set it."
        ) from missing
    except ValueError as error:
        raise Unusable(f"recall.toml: channel {name!r}: {error}; write $$ for a dollar.") from error
    if Apprise.instantiate(whole) is None:
        raise Unusable(
            f"recall.toml: channel {name!r} is not an Apprise URL (mailto://, dingtalk://, "
            "wecombot://, feishu://, slack://); correct it there."
        )
    return whole


def send(url: str, title: str, body: str, entry: bytes) -> str | None:
    """Sends a message; gives why it could not be sent, None where it was.

    entry: a calendar, which goes with it where the channel takes files.
    """
    from apprise import Apprise, AppriseAttachment, NotifyFormat
    from apprise.attachment.memory import AttachMemory

    channel = Apprise.instantiate(url)
    if channel is None:
        return "the channel is not an Apprise URL"
    attached = None
    if channel.attachment_support:
        attached = AppriseAttachment()
        attached.add(AttachMemory(content=entry, name=ENTRY, mimetype="text/calendar"))
    with _warnings() as warned:
        done = channel.notify(
            body=body, title=title, body_format=NotifyFormat.TEXT, attach=attached
        )  # fmt: skip
    if done:
        return None
    return warned[-1] if warned else NO_REASON


@contextmanager
def _warnings() -> Iterator[list[str]]:
    """What Apprise logs as a warning, which is the only place where it says what went wrong."""
    warned: list[str] = []
    catcher = logging.Handler(logging.WARNING)
    catcher.emit = lambda record: warned.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger("apprise")
    logger.addHandler(catcher)
    try:
        yield warned
    finally:
        logger.removeHandler(catcher)
