"""Where a kind of behaviour may stand in a form that no publication lists, and what competes there.

Classes are compared: a kind of behaviour, as a random function of its own drive, with the listed
forms of every name and with empirical terms, less those that the kinds have among their forms.
"""

from collections.abc import Sequence

from tasks.explain.explanation import COVERAGE, UNNAMED
from tasks.explain.search.candidates import Candidate, behaviours
from tasks.explain.search.empirical import empirical
from tasks.explain.search.stepwise import Selected
from tasks.model.model import Model
from tasks.model.term import COUNTS, Term
from tasks.model.terms.hysteresis import PLAYS
from tasks.motion.whole import Motion


def with_kinds(
    listed: Sequence[Term], selected: Sequence[Selected], model: Model, motion: Motion
) -> tuple[Term, ...]:
    """The terms to search with kinds of behaviour; none where none is in question.

    listed: terms of the catalogue. selected: what a search of them and of empirical terms selected,
    model: fitted to it. Kinds are in question where something has no name, or a form in doubt; but
    not where a delay or a filter is as clear, or in every model: what one differs by from the other
    follows changes of the motion, as memory does.
    """
    doubtful = [one for one in selected if _in_doubt(one.candidate, model)]
    signal = [one for one in selected if one.candidate.term.stage == "signal"]
    least = max((one.gain for one in signal), default=0.0)
    clear = any(one.gain > least for one in doubtful)
    if not clear or any(one.candidate.nuisance for one in signal):
        return ()
    kinds = tuple(behaviours(motion))
    names = {kind.name for kind in kinds}
    of_kinds = [kind.form_of for kind in kinds]
    left_out = {follows: one.channels for one in of_kinds for follows in one.empirical}
    forms = {one.candidate.term.equation for one in doubtful if one.candidate.name in names}
    return (
        *(term for term in listed if term.source != PLAYS and term.equation not in forms),
        *empirical(motion, left_out),
        *kinds,
    )


def _in_doubt(one: Candidate, model: Model) -> bool:
    """Whether it may be a behaviour in another form: it has no name; it is a sum of plays, which
    any hysteresis is; or its shape or its size is driven to where its own form ends.
    """
    if one.nuisance:
        return False
    return (
        one.name == UNNAMED
        or one.term.source == PLAYS
        or is_at_bound(one.term)
        or _of_other_sign(one.term, model)
    )


def is_at_bound(term: Term) -> bool:
    """Whether a continuous shape was driven out of what is plausible: another form fits better."""
    for shape, value in zip(term.shapes, term.at, strict=True):
        low, high = shape.plausible
        searched = shape.unit not in (COUNTS, "deg") and shape.name != "time"
        if searched and (value >= 0.99 * high or value <= 1.01 * low):
            return True
    return False


def _of_other_sign(term: Term, model: Model) -> bool:
    """Whether what can only take off, as friction, would add."""
    place = model.places[term.key]
    for parameter, value, u in zip(
        term.parameters, model.values[place], model.u[place], strict=True
    ):
        low, high = parameter.plausible
        if (low == 0.0 and value < -COVERAGE * u) or (high == 0.0 and value > COVERAGE * u):
            return True
    return False
