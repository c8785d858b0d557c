"""Where a kind of behaviour may stand in a form that no publication lists, and what competes there.

Classes are compared: a kind of behaviour, as a random function of its own drive, with the listed
forms of every name and with empirical terms, less those that the kinds have among their forms.
"""

from collections.abc import Sequence

from tasks.explain.explanation import UNNAMED
from tasks.explain.inputs.remarks import COVERAGE
from tasks.explain.search.behaviours import behaviours
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.empirical import empirical
from tasks.model.model import Model
from tasks.model.term import Term
from tasks.model.terms.hysteresis import PLAYS
from tasks.motion.whole import Motion


def with_kinds(
    listed: Sequence[Term], selected: Sequence[Candidate], model: Model, motion: Motion
) -> tuple[Term, ...]:
    """The terms to search with kinds of behaviour; none where none is in question.

    listed: terms of the catalogue. selected: what a search of them and of empirical terms selected,
    model: fitted to it. Kinds are in question where something has no name, or a form in doubt.
    """
    in_doubt = {one.term.equation for one in selected if _in_doubt(one.term, model)}
    unnamed = any(one.name == UNNAMED and not one.nuisance for one in selected)
    # What a filter differs by from a delay follows changes of the motion, as memory does.
    filtered = any(one.term.stage == "signal" for one in selected)
    if filtered or not (unnamed or in_doubt):
        return ()
    return (
        *(term for term in listed if term.source != PLAYS and term.equation not in in_doubt),
        *empirical(motion, beside_kinds=True),
        *behaviours(motion),
    )


def _in_doubt(term: Term, model: Model) -> bool:
    """Whether its behaviour may have another form: any hysteresis is a sum of plays; and what can
    only take off, as friction, does not add.
    """
    if term.source == PLAYS:
        return True
    place = model.places[term.key]
    for parameter, value, u in zip(
        term.parameters, model.values[place], model.u[place], strict=True
    ):
        low, high = parameter.plausible
        if (low == 0.0 and value < -COVERAGE * u) or (high == 0.0 and value > COVERAGE * u):
            return True
    return False
