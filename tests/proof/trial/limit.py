"""What nobody can beat: the power of a detector that knows an effect's form."""

from scipy.stats import chi2, ncx2

from tasks.explain.search.stepwise import FALSE_ALARMS
from tests.proof.plant.effects import EFFECTS
from tests.proof.trial.parameters import Truth, known_parameters


def freedom_of(truth: Truth, effect: str) -> int:
    """How many numbers an effect's form leaves open, at least one."""
    known = known_parameters(truth, effect)
    if known:
        return len(known)
    own = truth.effects[effect]
    return max(1, sum(_count(own.get(name, ())) for name in EFFECTS[effect].sized))


def _count(value: object) -> int:
    return sum(map(_count, value)) if isinstance(value, list | tuple) else 1


def power(z: float, freedom: int) -> float:
    """Probability that χ² of the form's own coordinates, whose mean is `freedom` without and
    freedom + z² with the effect, exceeds what chance does in 1 % of clean recordings.

    The form is known and nothing else is looked for; non-linear parameters count like linear ones.
    """
    bound = float(chi2.isf(FALSE_ALARMS, freedom))
    return float(ncx2.sf(bound, freedom, z * z))
