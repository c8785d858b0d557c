"""Manages the users of the operations pages: `mimucal user add|list|remove`."""

import sys

import typer

from flows import options
from schemas.base import Unusable
from storage.home import home

app = typer.Typer(help="Who may log in to the operations pages, and in which role.")
SHORTEST = 10  # characters of a password
LONGEST = 100  # characters of a name


@app.command(epilog='Example: mimucal user add "Wang Li" --role operator --by "Chen Jie"')
def add(name: options.UserName, role: options.UserRole, by: options.By = None) -> None:
    """Add a user, or change the role and password of one.

    The password is prompted for at a terminal, or read from the first line of standard input.
    """
    from flows.pages.login import hashed
    from schemas.access import ROLES
    from storage.catalogue import users

    chosen = next((each for each in ROLES if each == role), None)
    if chosen is None:
        raise Unusable(f"--role {role}: choose one of {', '.join(ROLES)}")
    if not 0 < len(name) <= LONGEST or name != name.strip():
        raise Unusable(
            f"{name[:LONGEST]!r} is not a valid user name; give 1 to {LONGEST} characters that "
            "neither begin nor end with a space."
        )
    if sys.stdin.isatty():
        given: str = typer.prompt(
            f"Password of {name}", hide_input=True, confirmation_prompt=True, err=True
        )
    else:
        given = sys.stdin.readline().rstrip("\n")
    if len(given) < SHORTEST:
        raise Unusable(f"The password has {len(given)} characters; give at least {SHORTEST}.")
    users.add(name, chosen, hashed(given), home(), options.person(by))
    print(f"{name}: {chosen}")


@app.command(name="list", epilog="Example: mimucal user list")
def list_(as_json: options.Json = False) -> None:
    """List the users and their roles."""
    from flows.terminal import print_json, print_rows
    from storage.catalogue import users

    every = users.users(home()).values()
    if as_json:
        shown = [each.model_dump(mode="json", exclude={"password"}) for each in every]
        print_json({"format": "mimu-users/1", "users": shown})
        return
    rows = [(each.name, each.role, f"{each.added_at:%F %R}") for each in every]
    print_rows("Users", ("name", "role", "since (UTC)"), rows)


@app.command(epilog='Example: mimucal user remove "Wang Li"')
def remove(name: options.UserName, by: options.By = None) -> None:
    """Remove a user and end that user's sessions."""
    from storage.catalogue import users

    users.remove(name, home(), options.person(by))
    print(f"{name} removed")
