"""Prints the audit trail as a table, as CSV, as JSON lines, or as one JSON document."""

import csv
import json
import sys

from flows.printing import print_json, print_rows
from schemas.base import Unusable
from storage.catalogue import trail
from storage.catalogue.trail import Entry
from storage.home import home


def print_trail(form: str) -> None:
    """Print every entry in the order of writing."""
    entries = trail.entries(home())
    if form == "json":
        print_json({"format": "mimu-trail/1", "entries": [_fields(entry) for entry in entries]})
    elif form == "jsonl":
        for entry in entries:
            print(json.dumps(_fields(entry), ensure_ascii=False))
    elif form == "csv":
        writer = csv.writer(sys.stdout, lineterminator="\n")
        writer.writerow(Entry.model_fields)
        writer.writerows(entry.model_dump(mode="json").values() for entry in entries)
    elif form == "table":
        rows = [
            (str(e.number), f"{e.at:%F %T}", e.person, e.action, e.subject, _reason(e))
            for e in entries
        ]
        print_rows("Trail", ("entry", "UTC", "person", "action", "subject", "reason"), rows)
    else:
        raise Unusable(f"--as {form}: choose one of table, csv, jsonl")


def _fields(entry: Entry) -> dict[str, object]:
    return entry.model_dump(mode="json") | {"details": json.loads(entry.details)}


def _reason(entry: Entry) -> str:
    return str(json.loads(entry.details).get("reason") or "")
