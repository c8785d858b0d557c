"""The environment variables of the program, which is all of its configuration outside the home."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pydantic import ConfigDict, Field

from schemas.base import Frozen
from schemas.secret_urls import shown

OWN = "MIMUCAL_"  # a variable with this prefix that is not listed here is a typing error


class Environment(Frozen):
    """Every variable that the program reads; one that is empty counts as not set."""

    model_config = ConfigDict(validate_by_name=True)

    home: Path = Field(
        default=Path("mimucal-data"), alias="MIMUCAL_HOME",
        description="Folder that holds everything; on a line one that all computers share.",
    )  # fmt: skip
    database: str | None = Field(
        default=None, alias="MIMUCAL_DATABASE", repr=False,
        description="The catalogue's PostgreSQL, as postgresql://user@host/name; "
        "unset: SQLite in the home.",
    )  # fmt: skip
    store: str | None = Field(
        default=None, alias="MIMUCAL_STORE",
        description="S3 bucket of the recordings, as s3://BUCKET/PREFIX?endpoint=HOST:PORT&scheme="
        "http (scheme and region where needed); unset: in the home. Keys are named as AWS does.",
    )  # fmt: skip
    station: Path | None = Field(
        default=None, alias="MIMUCAL_STATION",
        description="Folder of the station's own computer for lock, status, stop and the recording "
        "of a run that is going on; unset: the home.",
    )  # fmt: skip
    user: str | None = Field(
        default=None, alias="MIMUCAL_USER",
        description="Person who drafts, checks, issues, amends, withdraws or deletes where --by "
        "names none.",
    )  # fmt: skip
    log: Literal["json", "text"] | None = Field(
        default=None, alias="MIMUCAL_LOG",
        description="json or text: events on standard error, each as a line of JSON or of text; "
        "unset: none, or text where MIMUCAL_LOG_LEVEL is set.",
    )  # fmt: skip
    log_level: Literal["debug", "info", "warning", "error"] | None = Field(
        default=None, alias="MIMUCAL_LOG_LEVEL",
        description="Least level of the events that are written; debug has each command to a "
        "device of the station; unset: info.",
    )  # fmt: skip
    debug: str | None = Field(
        default=None, alias="MIMUCAL_DEBUG",
        description="Set to anything: a failure of the program shows where it happened.",
    )  # fmt: skip
    signing_passphrase: str | None = Field(
        default=None, alias="MIMUCAL_SIGNING_PASSPHRASE", repr=False,
        description="Passphrase or PIN of the key that signs certificates.",
    )  # fmt: skip
    prefect_server: str | None = Field(
        default=None, alias="PREFECT_API_URL",
        description="Prefect server, as http://HOST:4200/api; unset: a command that needs one "
        "starts its own.",
    )  # fmt: skip
    prefect_login: str | None = Field(
        default=None, alias="PREFECT_API_AUTH_STRING", repr=False,
        description="NAME:PASSWORD with which that server is asked (the server's own "
        "PREFECT_SERVER_API_AUTH_STRING).",
    )  # fmt: skip


@dataclass(frozen=True)
class Row:
    """A variable as it is shown: a secret as ***, nothing for one that is not set."""

    variable: str
    value: str | None
    source: Literal["environment", "default"]
    what: str


def in_rows(environment: Environment) -> list[Row]:
    """Each variable with its value and where that comes from."""
    rows = []
    for name, field in Environment.model_fields.items():
        value = getattr(environment, name)
        printed = "***" if value is not None and not field.repr else value
        is_set = name in environment.model_fields_set
        rows.append(
            Row(
                variable=str(field.alias),
                value=None if printed is None else shown(str(printed)),
                source="environment" if is_set else "default",
                what=str(field.description),
            )
        )
    return rows


def variables() -> dict[str, str]:
    """The variable of each field."""
    return {name: str(field.alias) for name, field in Environment.model_fields.items()}
