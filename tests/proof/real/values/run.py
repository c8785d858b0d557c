"""Explains a recording, and keeps of the answer what the page of values shows."""

from typing import Any

from schemas.base import Unusable
from schemas.recording import Recording
from tasks.explain import explain
from tasks.explain.explanation import Finding
from tasks.words import say


def explained(recording: Recording) -> dict[str, Any]:
    """The answer as data; a recording that explain refuses with what it says of it."""
    try:
        found = explain.explain(recording)
    except Unusable as refusal:
        return {"refused": str(refusal), "findings": []}
    return {
        "verdict": found.verdict,
        "p_value": found.p_value,
        "explained_share": found.explained_share,
        "findings": [_finding(one) for one in found.findings],
        "remarks": [say(remark, "en") for remark in found.remarks],
    }


def _finding(one: Finding) -> dict[str, Any]:
    return {
        "effect": one.effect,
        "group": [name for name in one.group if name != one.effect],
        "behaviour": say(one.behaviour or one.title, "en"),
        "refused": one.refusal and f"{one.refusal.name}, {one.refusal.kind}",
        "share": one.share,
        "parameters": [each.model_dump() for each in one.parameters],
    }
