"""What `--help` says of each command: what it does, and one example that is a command."""

import shlex
from collections.abc import Iterator
from typing import Any

import pytest
import typer

from flows import cli


def commands(group: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, (*path, name))
        else:
            yield (*path, name), command


EVERY = dict(commands(typer.main.get_command(cli.app), ("mimucal",)))


@pytest.mark.parametrize("path", EVERY, ids=" ".join)
def test_help_says_what_a_command_does_and_ends_with_an_example_of_it(path):
    command = EVERY[path]
    assert command.help
    example = shlex.split(command.epilog.removeprefix("Example: "))
    assert tuple(example[: len(path)]) == path
    context = command.make_context(path[-1], [], resilient_parsing=True)
    given, left, _ = command.make_parser(context).parse_args(args=example[len(path) :])
    assert left == []
    assert {each.name for each in command.params if each.required} <= {
        name for name, value in given.items() if value not in (None, ())
    }


def test_an_example_fits_on_one_line_of_a_terminal():
    assert max(len(command.epilog) for command in EVERY.values()) <= 78


def test_the_command_line_names_every_group_and_command(mimucal):
    shown = mimucal("--help").out
    assert {path[1] for path in EVERY} <= set(shown.split())
