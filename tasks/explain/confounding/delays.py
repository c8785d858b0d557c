"""Effects that make a unit late, and so make up for one another: by how much each does."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.search.candidates import Candidate
from tasks.model.model import Model
from tasks.model.term import Term, TermKey

Form = tuple[Candidate, ...]

GYROS_ALONE = "gyro_angular_acceleration"
DELAYING = ("time_offset", "bandwidth", GYROS_ALONE, "accel_axis_skew")
ROOT2, THIRD = float(np.sqrt(2.0)), 1.0 / 3.0


@dataclass(frozen=True)
class GroupDelay:
    """By how much a triad is late at low frequency, per unit of a parameter; s."""

    gyro: float
    accel: float


# Of a low-pass of second order √2/(2πf) = √2·T, of one of first order T; of ω′ = ω + A·ω̇ it is
# −A; the accelerometers' axes are read none, one and two steps ahead.
GROUP_DELAYS = {
    ("time_offset", "seconds"): GroupDelay(1.0, 1.0),
    ("bandwidth", "time_constant"): GroupDelay(ROOT2, ROOT2),
    ("bandwidth", "gyro_time_constant"): GroupDelay(ROOT2, 0.0),
    ("bandwidth", "accel_time_constant"): GroupDelay(0.0, ROOT2),
    ("bandwidth", "lag"): GroupDelay(1.0, 1.0),
    ("bandwidth", "gyro_lag"): GroupDelay(1.0, 0.0),
    ("bandwidth", "accel_lag"): GroupDelay(0.0, 1.0),
    (GYROS_ALONE, "A_xx"): GroupDelay(-THIRD, 0.0),
    (GYROS_ALONE, "A_yy"): GroupDelay(-THIRD, 0.0),
    (GYROS_ALONE, "A_zz"): GroupDelay(-THIRD, 0.0),
    ("accel_axis_skew", "step"): GroupDelay(0.0, -1.0),
}


def delay_of_low_pass(low_pass: Term) -> float:
    """By how much it is late at low frequency, per unit of its time constants."""
    delay = GROUP_DELAYS[low_pass.name, low_pass.parameters[0].name]
    return max(delay.gyro, delay.accel)


def forms_of(candidates: Sequence[Candidate], selected: Sequence[Candidate]) -> list[Form]:
    """The forms of delays and filters, each as candidates to represent it: those selected, else
    those with the same parameters as selected ones of another effect, else all.
    """
    found: list[Form] = []
    for name in DELAYING:
        own = tuple(one for one in selected if one.name == name)
        found += [own] if own else []
        forms: dict[TermKey, list[Candidate]] = {}
        for one in candidates:
            if one.is_form_of((name,)) and one.term.key not in [other.term.key for other in own]:
                forms.setdefault(one.term.key, []).append(one)
        found += [_alike(some, selected) for some in forms.values()]
    return found


def _alike(form: Sequence[Candidate], selected: Sequence[Candidate]) -> Form:
    names = [p.name for p in form[0].term.parameters]
    parts = [one.own for one in selected if [p.name for p in one.term.parameters] == names]
    return tuple(one for one in form if one.own in parts) or (form[0],)


def shape_count(members: Form) -> int:
    """Number of time constants and the like that are fitted, each as free as a parameter."""
    return sum(len(term.shapes) for term in {one.term.key: one.term for one in members}.values())


def starting_values(model: Model, members: Form, delays: tuple[float, float]) -> Model:
    """The model with delays and filters of such sizes that gyros and accelerometers are late by
    so much (s), as a fit may start from. Beside a delay a filter is what the later triad has.
    """
    values, names = model.values.copy(), {one.name for one in members}
    both = {"time_offset", "bandwidth"} <= names
    late = min(delays) if both else float(np.mean(delays))
    left = [delay - late if both else delay for delay in delays]
    whole, gyro, accel = (max(each, 0.0) for each in (float(np.mean(left)), *left))
    sizes = {
        "seconds": late,
        "time_constant": whole / ROOT2,
        "gyro_time_constant": gyro / ROOT2,
        "accel_time_constant": accel / ROOT2,
        "lag": whole,
        "gyro_lag": gyro,
        "accel_lag": accel,
    }
    for one in members:
        for p, parameter in enumerate(one.term.parameters, model.places[one.term.key].start):
            if (one.name, parameter.name) in GROUP_DELAYS and parameter.name in sizes:
                values[p] = sizes[parameter.name]
    return replace(model, values=values)


def common_part(
    model: Model, terms: Sequence[Term], names: Sequence[str], widening: np.ndarray
) -> tuple[FoundParameter, ...]:
    """Group delay of gyros and of accelerometers by all the terms together, with its uncertainty;
    empty for effects that are not delays. names: of the group; if one of them is not among the
    terms and delays gyros only, the delay of the accelerometers is not known.

    widening: (p,) factors by which the residual, and the differences between the recording's parts,
    widen the uncertainty of each of the model's parameters.
    """
    weights = _delay_weights(model, terms)
    widened = weights * widening
    u = np.sqrt(np.einsum("kp,pq,kq->k", widened, model.covariance, widened))
    values = weights @ model.values
    of_gyros = GYROS_ALONE in names and GYROS_ALONE not in [term.name for term in terms]
    pairs = zip(("gyro_group_delay", "accel_group_delay"), values.tolist(), u.tolist(), strict=True)
    return tuple(
        FoundParameter(name=name, value=value, unit="s", u=spread)
        for name, value, spread in pairs
        if spread > 0.0 and not (name == "accel_group_delay" and of_gyros)
    )


def group_delays(model: Model, names: Sequence[str]) -> tuple[float, float]:
    """Of gyros and of accelerometers by all the terms of some names together, s."""
    terms = [term for term in model.terms if term.name in names]
    gyro, accel = (_delay_weights(model, terms) @ model.values).tolist()
    return gyro, accel


def _delay_weights(model: Model, terms: Sequence[Term]) -> np.ndarray:
    """(2, p) group delay of gyros and accelerometers per unit of each of the model's parameters."""
    weights = np.zeros((2, len(model.values)))
    for term in terms:
        for p, parameter in enumerate(term.parameters, model.places[term.key].start):
            delay = GROUP_DELAYS.get((term.name, parameter.name), GroupDelay(0.0, 0.0))
            weights[:, p] = delay.gyro, delay.accel
    return weights
