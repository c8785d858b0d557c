"""The outcome of a step of a run, in words and as one of four kinds that pages.css colours.

Nothing that failed, is missing, is invalid or was taken back is good: `good` is stated, never the
rest of a case distinction.
"""

from typing import Literal, NamedTuple

from dash import html
from dash.development.base_component import Component

from flows.pages.page import View
from schemas.certificate import LIVE
from schemas.decision import LimitDecision, Verdict
from storage.catalogue.run_states import RunLine
from tasks.conformity.limits import verdict_title
from tasks.words import Argument, Sayable, message

Kind = Literal["good", "open", "bad", "none"]
KINDS: dict[Verdict, Kind] = {"pass": "good", "fail": "bad", "inconclusive": "open"}


class StepState(NamedTuple):
    """A step's state as it is shown."""

    words: Sayable
    kind: Kind


def stated(id_: str, kind: Kind, **arguments: Argument) -> StepState:
    """A state whose words are a message by its identifier."""
    return StepState(message(id_, **arguments), kind)


def validity_state(verdict: str | None) -> StepState:
    """The verdict on a run."""
    kinds: dict[str | None, Kind] = {"valid": "good", "remarks": "open", "invalid": "bad"}
    return stated(f"pages-validity.{verdict or 'missing'}", kinds.get(verdict, "none"))


def result_state(run: RunLine) -> StepState:
    """Whether a run has a result, and a whole one."""
    kinds: dict[str, Kind] = {"failed": "bad", "missing": "none", "partial": "open"}
    kind = kinds.get(run.result_state) or ("bad" if run.validity == "invalid" else "good")
    return stated(f"pages-result.{run.result_state}", kind, count=run.missing or 0)


def certificate_state(state: str | None) -> StepState:
    """Where a certificate stands in its life."""
    kinds: dict[str | None, Kind] = {
        "draft": "open", "checked": "open", "issued": "good", "amended": "none", "withdrawn": "bad",
    }  # fmt: skip
    return stated(f"pages-certificate.{state or 'missing'}", kinds.get(state, "none"))


def decision_state(verdict: Verdict | None) -> StepState:
    """The verdict of a certificate."""
    if verdict is None:
        return stated("pages-verdict-missing", "none")
    return stated(f"conformity-verdict.{verdict}", KINDS[verdict])


def verdict_state(run: RunLine) -> StepState:
    """The verdict on the unit; a pass is good only on a run that bears it."""
    state = decision_state(run.verdict)
    stands = run.validity == "valid" and run.fault is None and run.state in LIVE
    return StepState(state.words, "open") if state.kind == "good" and not stands else state


def limit_state(decision: LimitDecision) -> StepState:
    """The verdict on one limit."""
    return StepState(verdict_title(decision), KINDS[decision.verdict])


def badge(state: StepState, view: View) -> Component:
    """A state as a word on its colour."""
    return html.Span(view.say(state.words), className=f"state state-{state.kind}")
