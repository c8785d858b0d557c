"""Who may acquire, check and issue, where the laboratory says so (ISO/IEC 17025:2017, 6.2)."""

from datetime import UTC, date, datetime

from schemas.access import Authority
from schemas.base import Unusable
from schemas.certificate import Laboratory
from schemas.recording import Standard
from tasks.stages.certificate_inputs import day_of_moment


def why_not(
    laboratory: Laboratory | None,
    person: str | None,
    act: Authority,
    standard: Standard,
    day: date,
) -> str | None:
    """Why a person is not authorised on a day, as a clause; None who is.

    A laboratory that names nobody in [[authorised]] has not turned this on.
    """
    if laboratory is None or not laboratory.authorised:
        return None
    if person is None:
        return f"nobody is named who may {act} by {standard}, which [[authorised]] asks for"
    own = [each for each in laboratory.authorised if each.name == person]
    may = [each for each in own if act in each.may]
    here = [each for each in may if not each.standards or standard in each.standards]
    if any(each.until is None or each.until >= day for each in here):
        return None
    if here:
        last = max(each.until for each in here if each.until)
        why = f"{person} was authorised to {act} by {standard} until {last}, before {day}"
    elif may:
        known = ", ".join(sorted({name for each in may for name in each.standards}))
        why = f"{person} is authorised to {act} by {known}, not by {standard}"
    else:
        known = ", ".join(sorted({name for each in own for name in each.may})) or "nothing"
        why = f"{person} is authorised to {known}, not to {act}"
    return why


def check_authorised(
    laboratory: Laboratory | None,
    person: str | None,
    act: Authority,
    standard: Standard,
    day: date,
) -> None:
    """Raises Unusable for a person who is not authorised."""
    if why := why_not(laboratory, person, act, standard, day):
        raise Unusable(
            f"{why}; let another person do it with --by NAME, or correct [[authorised]] in "
            "laboratory.toml."
        )


def authorised_operator(
    by: str | None, standard: Standard, laboratory: Laboratory | None
) -> str | None:
    """Who carries out a measurement now: whom the order names, else the laboratory's operator.

    Raises Unusable for a person who is not authorised.
    """
    operator = by or (laboratory.operator if laboratory else None)
    check_authorised(laboratory, operator, "acquire", standard, day_of_moment(datetime.now(UTC)))
    return operator
