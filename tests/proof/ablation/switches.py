"""The rules and constants of evidence and scrutiny that are switched off, as data.

A rule that is a function says nothing, or hands on what it was given; a constant stands at a value
that disables what it is for. Those of confounding are in `comparisons`.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from tasks.explain.evidence.evidence import Evidence
from tasks.explain.search.stepwise import FALSE_ALARMS
from tests.proof.ablation.switch import Switch

INF = float("inf")


def says(value: Any) -> Callable[..., Any]:
    """A function that always says this."""
    return lambda *args, **named: value


def first(given: Any, *rest: Any, **named: Any) -> Any:
    """What it was given."""
    return given


def second(given: Any, other: Any, *rest: Any, **named: Any) -> Any:
    """The second of what it was given; of a method the first."""
    return other


def _without_chance(evidence: Evidence, number: int, trials: int) -> bool:
    group, held_out = evidence.groups[number], evidence.held_out_gain(number)
    if group.absorbed_by:
        return False
    return held_out <= 0.0 or (not group.random and evidence.delta_bic(number) <= 0.0)


def _without_held_out(evidence: Evidence, number: int, trials: int) -> bool:
    if evidence.groups[number].absorbed_by:
        return False
    if evidence.groups[number].random:
        return evidence.held_out_gain(number) <= 0.0
    chance = evidence.chance(number) * trials
    return chance > FALSE_ALARMS or evidence.delta_bic(number) <= 0.0


def _without_bic(evidence: Evidence, number: int, trials: int) -> bool:
    group, held_out = evidence.groups[number], evidence.held_out_gain(number)
    if group.absorbed_by:
        return False
    return held_out <= 0.0 or (not group.random and evidence.chance(number) * trials > FALSE_ALARMS)


def _gain_over_dispersion(self: Evidence, number: int) -> float:
    return max(self.gain(number), 0.0) / self.scatter.dispersion(number)


def _as_last(self: Evidence, number: int) -> float:
    return self.gain(number)


def _whole_price(self: Evidence, number: int) -> float:
    """BIC by all readings."""
    return self.evidence(number) - self.groups[number].parameter_count * float(np.log(self.used))


def _no_loss(evidence: Evidence, *rest: Any) -> tuple[np.ndarray, np.ndarray]:
    count = evidence.whole.count
    return np.eye(count), np.zeros(count)


def _none_moved(evidence: Evidence, numbers: Any) -> np.ndarray:
    return np.zeros(evidence.whole.count)


def _none_loose(model: Any, owned: Any, wider: np.ndarray) -> np.ndarray:
    return np.zeros(len(model.values), bool)


def _not_wider(evidence: Evidence, scrutinies: Any) -> np.ndarray:
    return np.ones(len(evidence.fit.model.values))


P, S, FE = "evidence.pruning", "evidence.scrutiny", "evidence.form_errors"
H, G, F, E = "evidence.shares", "evidence.groups", "evidence.findings", "evidence.event_findings"
LEFT, C, SC = "evidence.left_over", "evidence.clipping", "evidence.scatter"
R, HO, D = "evidence.reference_errors", "evidence.homogeneity", "evidence.determination"
UNSUPPORTED, SCRUTINY = f"{P}:unsupported", f"{S}:Scrutiny.of"
PHI = f"{SC}:CellInfluence._dispersion"

PRUNING = (
    Switch("pruning", "takes out what does not stand beside the rest", UNSUPPORTED, says(False)),
    Switch("pruning by chance", "Bonferroni p of each finding", UNSUPPORTED, _without_chance),
    Switch("pruning by held-out", "held-out segments predicted better",
           UNSUPPORTED, _without_held_out),
    Switch("pruning by ΔBIC", "parameters paid for", UNSUPPORTED, _without_bic),
    Switch("WRONG_MODEL", "from which φ a random drift is judged as a law",
           f"{P}:WRONG_MODEL", INF, UNSUPPORTED),
    Switch("with_absorbed", "known physics that the standard absorbs", f"{P}:absorbed", says(None)),
    Switch("MAX_MISFIT", "absorbing parameters are otherwise nothing",
           f"{P}:MAX_MISFIT", 0.0, f"{P}:absorbed"),
    Switch("evidence: log1p", "noise not known beforehand (Student)",
           "evidence.evidence:Evidence.evidence", _gain_over_dispersion, every=4),
    Switch("ΔBIC by cells", "price by informative cells, not readings",
           "evidence.evidence:Evidence.delta_bic", _whole_price, every=2),
    Switch("together", "share as mean of first and last",
           "evidence.evidence:Evidence.together", _as_last, every=4),
)  # fmt: skip

SCRUTINISED = (
    Switch("implausible", "beyond the plausible range", f"{S}:_implausible", says(None)),
    Switch("inhomogeneous", "differs between parts of the recording",
           f"{S}:_inhomogeneous", says(None)),
    Switch("UNLIKE", "from which p parts differ: refusal and wider u",
           f"{S}:UNLIKE", 0.0, SCRUTINY),
    Switch("MATERIAL", "parts that differ by less are one law",
           f"{S}:MATERIAL", 0.0, f"{S}:_inhomogeneous"),
    Switch("channel_worse", "a channel is predicted worse", f"{S}:_channel_worse", says(None)),
    Switch("TOUCHED", "χ² that touches a channel", f"{S}:TOUCHED", 0.0, f"{S}:_channel_worse", 2),
    Switch("MIN_TOUCHED", "share that touches a channel",
           f"{S}:MIN_TOUCHED", 0.0, f"{S}:_channel_worse"),
    Switch("TOLERATED", "nats a channel may lose", f"{S}:TOLERATED", 0.0, f"{S}:_channel_worse"),
    Switch("undetermined", "no parameter exceeds its U", f"{S}:_undetermined", says(None)),
    Switch("unseen_turning", "dead band made by a rest's errors",
           f"{S}:unseen_turning", says(None)),
    Switch("made_by_placing", "as many parameters as placements",
           f"{S}:made_by_placing", says(None)),
    Switch("jump_at_one_end", "jump with too few cells on a side",
           f"{S}:jump_at_one_end", says(None)),
    Switch("loops_both_ways", "memory with weights of both signs",
           f"{S}:loops_both_ways", says(None)),
    Switch("swings", "low-pass that is a swinging mount", f"{S}:swings", says(None)),
    Switch("DETERMINED", "share of information that a part needs",
           f"{HO}:DETERMINED", 0.0, f"{HO}:partwise", 4),
    Switch("MIN_DEGREES", "of the scatter between parts",
           f"{HO}:MIN_DEGREES", 1.0, f"{HO}:partwise", 4),
    Switch("φ", "scatter between cells widens all", PHI, says((1.0, INF))),
    Switch("φ: WITHIN", "nearer to one it is noise", f"{SC}:WITHIN", 0.0, PHI, 2),
    Switch("φ: CHANCE", "believed only where chance does not make it", f"{SC}:CHANCE", 1.0, PHI, 2),
    Switch("φ: MOST_LEVERAGE", "of one cell",
           f"{SC}:MOST_LEVERAGE", 1.0 - 1e-9, f"{SC}:CellInfluence._dispersion", 4),
    Switch("MOST_PRIOR", "what the prior determines is none",
           f"{SC}:MOST_PRIOR", INF, f"{SC}:Scatter._among", 4),
)  # fmt: skip

NAMED = (
    Switch("at_bound", "shape driven to its limit", f"{G}:is_at_bound", says(False)),
    Switch("at_one_place", "neighbouring orders a turn", f"{G}:_at_one_place", says(False)),
    Switch("several jumps", "steps at several times are no bias_step",
           f"{G}:SAME_STEP", INF, f"{G}:_name_of"),
    Switch("form errors", "what the forms of everything else may leave",
           f"{FE}:named_beside", first),
    Switch("PUBLISHED", "a published form is exact", f"{FE}:PUBLISHED", 0.0, f"{FE}:named_beside"),
    Switch("UNPUBLISHED", "what has no name leaves no more than what has",
           f"{FE}:UNPUBLISHED", 0.03, f"{FE}:named_beside"),
    Switch("switching", "walk that changes at two moments", f"{H}:_switches", says(False)),
    Switch("small", "less than 2 % told in one line", f"{H}:small_remainder", says(False)),
    Switch("remainder", "what nothing explains as a finding", f"{LEFT}:remainder", says(None)),
    Switch("REFERENCE_KNOWN", "remainder beyond ten times the reference's noise",
           f"{LEFT}:REFERENCE_KNOWN", 1.0, f"{LEFT}:remainder"),
    Switch("KNOWN_WITHIN", "noise known within 10 %",
           f"{LEFT}:KNOWN_WITHIN", 0.0, f"{LEFT}:LeftOver.remaining_by_channel", 4),
    Switch("vibration", "noise of each segment",
           f"{LEFT}:_vibration", lambda full: np.ones(full.readings.shape), every=2),
    Switch("rest noise: LEAST", "least of the usual noise",
           f"{LEFT}:LEAST", 0.0, f"{LEFT}:rest_noise", 2),
    Switch("only a nuisance", "frame, delay without own evidence",
           f"{F}:_only_a_nuisance", says(False)),
    Switch("beside implausible", "u covers a fit without them",
           f"{F}:_beside_implausible", lambda e, s: dict(s)),
    Switch("MAX_U", "parameters known no better than before",
           f"{F}:MAX_U", INF, f"{F}:_parameters", 4),
    Switch("MIN_SHARE of a channel", "channels with less are not named",
           f"{F}:MIN_SHARE", 0.0, f"{F}:_channels", 4),
    Switch("MOVING", "or that clearly move", f"{F}:MOVING", INF, f"{F}:_channels", 4),
    Switch("undetermined parameters", "held at nothing", f"{D}:undetermined", _none_loose),
    Switch("widening", "of the correction's covariance", f"{D}:widening", _not_wider, every=4),
    Switch("clipped", "bend at one size of rate may be clipping",
           f"{F}:possibly_clipped", says(())),
    Switch("clipped in noise", "bend at one end may be clipping",
           f"{F}:possibly_clipped_in_noise", says(())),
    Switch("noise is cut", "by the noise alone", f"{C}:_noise_is_cut", says(False)),
    Switch("reference's noise", "made by errors of the encoder",
           "evidence.assemble:fitted_to_reference_noise", says(set())),
    Switch("made by chance", "what they earn by chance", f"{R}:made_by_chance", says(False)),
    Switch("smoothing error", "u of what smoothing loses",
           "evidence.assemble:with_smoothing_error", first, every=2),
    Switch("smoothing error of encoders", "the same of encoders",
           f"{R}:_lost_of_encoders", _no_loss, every=2),
    Switch("limits need more", "100 ΔBIC for saturation", f"{E}:_needed", says(0.0)),
    Switch("CONTRADICTED", "readings speak against an event",
           f"{E}:CONTRADICTED", INF, f"{E}:_gain"),
    Switch("CLEAR of events", "changes beyond the reference's errors",
           f"{E}:CLEAR", 0.0, f"{E}:_gain"),
    Switch("events: φ", "counted against what is left", f"{E}:_left_in", says(1.0)),
)  # fmt: skip

EVIDENCE = (*PRUNING, *SCRUTINISED, *NAMED)

# Rules that make up for one another: off together where more than one of them acts.
TOGETHER: dict[str, tuple[str, ...]] = {
    "all look-alikes": (
        "unseen_turning", "made_by_placing", "jump_at_one_end", "loops_both_ways", "swings",
        "switching",
    ),
    "all of parts and channels": ("inhomogeneous", "channel_worse"),
    "all of the reference": ("reference's noise", "smoothing error"),
    "all of clipping": ("clipped", "clipped in noise"),
}  # fmt: skip
