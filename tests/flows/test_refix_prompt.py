"""The person at the terminal, on a terminal of its own."""

import asyncio
import os
import pty
import sys
from collections.abc import Iterator

import pytest

from flows import refix_prompt
from schemas.base import Unusable
from schemas.procedure import Procedure, Refix
from tasks.station import procedures

WHOLE: Procedure = procedures.load("jjf1536")
REFIX = next(step for step in WHOLE.steps if isinstance(step, Refix))


@pytest.fixture
def keyboard(monkeypatch) -> Iterator[int]:
    """The other end of a terminal that is standard input."""
    keys, terminal = pty.openpty()
    with os.fdopen(terminal) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keys
    os.close(keys)


async def asked(keys: int, *, after_s: float) -> float:
    """How long a question waited (s) when Enter is pressed so long after it was asked."""
    loop = asyncio.get_running_loop()
    ask, began = refix_prompt.at_terminal(), loop.time()
    assert ask is not None
    loop.call_later(after_s, os.write, keys, b"\n")
    await asyncio.wait_for(ask(REFIX), 10.0)
    return loop.time() - began


def test_enter_says_that_the_unit_was_turned_over(keyboard, capsys):
    assert asyncio.run(asked(keyboard, after_s=0.05)) >= 0.05
    printed = " ".join(capsys.readouterr().err.split())
    assert REFIX.instruction in printed
    assert "press Enter" in printed


def test_an_enter_pressed_before_it_was_asked_does_not_count(keyboard):
    os.write(keyboard, b"\n\n")
    assert asyncio.run(asked(keyboard, after_s=0.2)) >= 0.2


def test_a_terminal_that_closes_ends_the_run_with_a_sentence(keyboard):
    async def close() -> None:
        asyncio.get_running_loop().call_later(0.05, os.write, keyboard, b"\x04")
        ask = refix_prompt.at_terminal()
        assert ask is not None
        await asyncio.wait_for(ask(REFIX), 10.0)

    with pytest.raises(Unusable, match="terminal was closed before the unit was turned over"):
        asyncio.run(close())


def test_where_standard_input_is_no_terminal_there_is_nobody(monkeypatch, tmp_path):
    with (tmp_path / "empty").open("w+") as file:
        monkeypatch.setattr(sys, "stdin", file)
        assert refix_prompt.at_terminal() is None
