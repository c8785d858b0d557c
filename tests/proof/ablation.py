"""Switches one rule or constant of `explain` off, and watches where that would change anything.

A function is replaced wherever it was imported, a constant in the module that is named.
"""

import ast
import importlib
import json
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from functools import cached_property, partial, wraps
from hashlib import blake2b
from itertools import chain, zip_longest
from pathlib import Path
from shutil import rmtree
from types import FunctionType
from typing import Any
from zlib import crc32

import numpy as np

from storage.formats.folder import read_folder
from tasks.explain import explain
from tasks.explain.events.event import Events
from tasks.explain.evidence import assemble
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.explanation import Explanation
from tasks.explain.inputs.prepared import Prepared, prepare
from tasks.explain.progress import silent
from tasks.explain.search.fitted import FittedSelection, Searched, searched
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.model import Model
from tasks.motion.whole import Motion
from tests.proof import station as station
from tests.proof.real.run import write
from tests.proof.real.stated import KNOWN, judged
from tests.proof.station import Case, cases, recording_of
from tests.proof.study import Minutes, Out, Real, Seed, Write, folder_of, hold, table
from tests.proof.trial.blind import UNNAMED
from tests.proof.trial.parameters import Truth, compared
from tests.proof.trial.rough import draw_rough, record_and_seal_rough, scored_rough
from tests.proof.trial.seal import DWELLS, RECORDINGS, SEALED, draw, record_and_seal

ENGINE = "tasks.explain"


@dataclass(frozen=True)
class Switch:
    """A rule, or a constant of one.

    purpose: what it is for. attribute: “module:name” or “module:Class.name” below ENGINE.
    replacement: what stands there when it is off. site: of a constant the function whose outcome
    it may change, named in the same way; a function is its own. every: it is tried on each so
    manieth recording, where it changes numbers on nearly all.
    """

    name: str
    purpose: str
    attribute: str
    replacement: Any
    site: str = ""
    every: int = 1

    @property
    def watched(self) -> str:
        return self.site or self.attribute


@contextmanager
def off(switch: Switch) -> Iterator[None]:
    """The engine without it."""
    with _put(switch.attribute, switch.replacement):
        yield


@dataclass
class Watch:
    """Which switches would have changed an outcome, and in which stages.

    A site's outcome is compared with what it would be without each of its switches, by the same
    arguments: where no call differs, the answer without the switch is the same.
    """

    switches: Sequence[Switch]
    stage: str = ""
    acted: dict[str, set[str]] = field(default_factory=dict)
    _comparing: bool = False

    @contextmanager
    def on(self) -> Iterator[None]:
        by_site: dict[str, list[Switch]] = {}
        for switch in self.switches:
            by_site.setdefault(switch.watched, []).append(switch)
        with ExitStack() as watching:
            for site, own in by_site.items():
                function = _function(site)
                watching.enter_context(_put(site, self._watched(function, own)))
            yield

    def _watched(self, function: FunctionType, own: Sequence[Switch]) -> FunctionType:
        @wraps(function)
        def watched(*args: Any, **named: Any) -> Any:
            outcome = function(*args, **named)
            if self._comparing:
                return outcome
            self._comparing = True
            try:
                for switch in own:
                    if self.stage in self.acted.get(switch.name, ()):
                        continue
                    other = self._without(switch, function, args, named)
                    if not alike(outcome, other):
                        self.acted.setdefault(switch.name, set()).add(self.stage)
            finally:
                self._comparing = False
            return outcome

        return watched  # type: ignore[return-value]

    def _without(
        self, switch: Switch, function: FunctionType, args: Sequence[Any], named: dict[str, Any]
    ) -> Any:
        if not switch.site:
            return switch.replacement(*args, **named)
        with off(switch):
            return function(*args, **named)


def alike(one: Any, other: Any) -> bool:
    """Whether two outcomes are equal, arrays and the fields of data classes element by element."""
    if one is other:
        return True
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and bool(np.array_equal(one, other, equal_nan=True))
    if type(one) is not type(other):
        return isinstance(one, int | float) and isinstance(other, int | float) and one == other
    if isinstance(one, float):
        return one == other or (one != one and other != other)
    if is_dataclass(one):
        return all(alike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(alike(one[k], other[k]) for k in one)
    return bool(one == other)


def _owner(path: str) -> tuple[Any, str]:
    module, _, name = path.partition(":")
    owner: Any = importlib.import_module(f"{ENGINE}.{module}")
    *classes, last = name.split(".")
    for each in classes:
        owner = getattr(owner, each)
    return owner, last


def _function(path: str) -> FunctionType:
    """The plain function behind a function, method, property or cached property."""
    owner, name = _owner(path)
    raw = vars(owner)[name]
    raw = getattr(raw, "func", None) or getattr(raw, "fget", None) or getattr(raw, "__func__", raw)
    if not isinstance(raw, FunctionType):
        raise TypeError(f"{path} is no function")
    return raw


@contextmanager
def _put(path: str, value: Any) -> Iterator[None]:
    """Another value in its place, of the same kind of attribute, as long as it lasts."""
    owner, name = _owner(path)
    raw = vars(owner)[name]
    places: list[Any]
    if isinstance(owner, type):
        places = [owner]
        value = _as_in_class(raw, name, value)
    elif callable(raw):
        engine = [m for key, m in sys.modules.items() if key.startswith(ENGINE) and m]
        places = [module for module in engine if vars(module).get(name) is raw]
    else:
        places = [owner]
    for place in places:
        setattr(place, name, value)
    try:
        yield
    finally:
        for place in places:
            setattr(place, name, raw)


def _as_in_class(raw: Any, name: str, value: Callable[..., Any]) -> Any:
    if isinstance(raw, cached_property):
        made = cached_property(value)
        made.__set_name__(None, name)  # type: ignore[arg-type]
        return made
    if isinstance(raw, property):
        return property(value)
    if isinstance(raw, classmethod):
        return classmethod(value)
    return value


# The rules and constants of evidence and scrutiny that are switched off, as data.
#
# A rule that is a function says nothing, or hands on what it was given; a constant stands at a
# value that disables what it is for. Those of confounding are in `comparisons`.

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


# The rules and constants of confounding that are switched off, as data.

COMPARING, L = "confounding.compare", "confounding.linear_forms"
DELAYS, FORMS = f"{COMPARING}:_Delays", f"{L}:LinearForms"
COMPARED = f"{COMPARING}:compared"


def _cheapest(self: Any, tried: Sequence[Any]) -> Any:
    return min(tried, key=self._cost)


def _only_clipped(group: Any, *rest: Any) -> tuple[str, ...]:
    return ()


COMPARISONS = (
    Switch("comparing", "combinations of what compensates", "explain:compared", first),
    Switch("play", "tips from side to side, not bends", "explain:with_play", first),
    Switch("preferred", "special cases and plausible ones first", "explain:with_preferred", first),
    Switch("fewest effects", "before what fits best", f"{DELAYS}._fewest_effects", _cheapest),
    Switch("pruned combinations", "what only made up for it",
           f"{DELAYS}._pruned", lambda self, tried: list(tried)),
    Switch("delay with filter", "both at once", f"{DELAYS}._delay_with_filter", says([])),
    Switch("promising pairs", "a second effect beside", f"{DELAYS}._promising", says(())),
    Switch("smooths", "a filter beside a delay promises more", f"{DELAYS}._smooths", says(False)),
    Switch("cancelled", "a lead that cancels a low-pass",
           "confounding.combinations:Combination.is_cancelled", says(False)),
    Switch("plausible", "within the range of a working unit",
           "confounding.combinations:Combination.plausible", says(True)),
    Switch("rivals of nuisances", "what fits as well as the delay",
           f"{DELAYS}.with_rivals", lambda self: self.fit),
    Switch("FORM of linear forms", "error of their form",
           f"{L}:FORM", 0.0, f"{FORMS}.distinguishable"),
    Switch("triads differ", "delays of each triad's own", f"{FORMS}.triads_differ", says(False)),
    Switch("rivals of the search", "names that fit as well in its place",
           "evidence.findings:_indistinguishable", _only_clipped),
    Switch("resolved", "blocks half as long", "search.fitted:Searched.resolved", second),
)  # fmt: skip


# How large the engine is: lines, numeric constants, names of effects outside their own files.

ROOT = Path(__file__).parents[2]
EXPLAIN = ROOT / "tasks/explain"
WORDS = ROOT / "tasks/words/en"
ENTRY = re.compile(r"^effect-([a-z0-9-]+) *=", re.MULTILINE)
OF_EVENTS = "events"  # an event has its name from the file that finds it


@dataclass(frozen=True)
class Counts:
    """lines: without blanks. constants: of modules, numbers or made of numbers. names: literal
    names of effects, but those of an event where it is found; files: that have them.
    """

    lines: int
    constants: int
    names: int
    files: int


def counts(folder: Path = EXPLAIN) -> Counts:
    """Of all modules of a package."""
    effects = _effects()
    lines = constants = names = files = 0
    for path in sorted(folder.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text)
        lines += sum(bool(line.strip()) for line in text.splitlines())
        constants += sum(_numbers(tree))
        own = sum(_literal(node) in effects for node in ast.walk(tree))
        if OF_EVENTS not in path.parts:
            names, files = names + own, files + bool(own)
    return Counts(lines, constants, names, files)


def _effects() -> set[str]:
    every = (path.read_text(encoding="utf-8") for path in WORDS.iterdir())
    return {name.replace("-", "_") for text in every for name in ENTRY.findall(text)} - {"unnamed"}


def _literal(node: ast.AST) -> object:
    return node.value if isinstance(node, ast.Constant) else None


def _numbers(tree: ast.Module) -> Iterator[int]:
    """How many numeric constants each assignment of a module makes."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and _is_numeric(node.value):
            for target in node.targets:
                yield len(target.elts) if isinstance(target, ast.Tuple) else 1


def _is_numeric(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value=bool()):
            return False
        case ast.Constant(value=int() | float()):
            return True
        case ast.UnaryOp(operand=operand):
            return _is_numeric(operand)
        case ast.BinOp(left=left, right=right):
            return _is_numeric(left) or _is_numeric(right)
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            return bool(elements) and all(map(_is_numeric, elements))
        case ast.Call(args=arguments):
            return any(map(_is_numeric, arguments))
    return False


# What one answer says that is right and wrong, by what is known of the recording.

Answer = Mapping[str, Any]


@dataclass(frozen=True)
class Verdict:
    """right: names that are true or stand in a group with a true one. wrong: the others, as far as
    the recording is known well enough. inside, stated: intervals with a truth beside them.
    """

    right: tuple[str, ...]
    wrong: tuple[str, ...]
    inside: int = 0
    stated: int = 0


def by_names(answer: Answer, true: set[str], pairs: tuple[int, int] = (0, 0)) -> Verdict:
    """By the names of all that is true of a recording. pairs: intervals inside, and of how many."""
    named = [one for one in answer["findings"] if one["effect"] != UNNAMED]
    right = [one for one in named if offered(one) & true]
    wrong = [one for one in named if not offered(one) & true]
    return Verdict(
        tuple(one["effect"] for one in right), tuple(one["effect"] for one in wrong), *pairs
    )


def offered(finding: Mapping[str, Any]) -> set[str]:
    """Every name that a finding offers for what it found."""
    return {
        finding["effect"], *(finding.get("group") or ()), *finding["indistinguishable_from"],
    }  # fmt: skip


# The kept recordings: of the sealed trial, the rough trial and the station, and the real ones.

MOST_OF = {"faint": 12, "several": 30, "clean": 20}  # recordings of a kind; of others one each
MOST_RATE = 100  # Hz
STATION_CASES = 60
# What is known to be true of a recording by those who reported it or by hand: names of the
# catalogue; those in `tests.proof.real.stated` are not repeated. All
# of `field` turn with Earth.
TRUE_OF: dict[str, set[str]] = {
    "bmi160_board1": {"code_fault"},
    "openaxes_triangle250_radius": {
        "axis_mapping",
        "reference_frame",
        "time_offset",
        "repeated_samples",
    },
    "phone_basic_motions": {"time_offset", "lever_arm", "reference_frame"},
    "ring_trial1_seg5": {"time_offset", "lever_arm", "reference_frame"},
    "sunsided_turns": {"axis_mapping", "timestamp_jitter"},
    "tumvi_calib_imu1": {"reference_frame"},
    "arrival_stamps_16ms": {"time_offset", "earth_rotation"},
    "gravity_removed": {"gravity_removed", "lever_arm", "earth_rotation"},
    "gyro_range_1137": {"range_setting", "earth_rotation"},
    "gyro_z_inverted_labels_only": {"axis_mapping", "earth_rotation"},
    "large_misalignment": {"earth_rotation"},
    "logger_1hz": {"earth_rotation"},
    "logger_2hz": {"earth_rotation"},
    "low_byte_signed": {"code_fault", "earth_rotation"},
    "low_byte_signed_25hz": {"code_fault", "earth_rotation"},
    "low_byte_signed_no_table": {"code_fault", "earth_rotation"},
    "low_byte_signed_or": {"code_fault", "earth_rotation"},
    "one_bad_row": {"earth_rotation"},
    "ten_bad_rows": {"earth_rotation"},
}


@dataclass(frozen=True)
class Kept:
    """A recording in a folder, how it is made there and how an answer about it is judged.

    last: the file that is written last; where it is, the recording is whole.
    """

    kind: str
    label: str
    folder: Path
    last: Path
    record: Callable[[], None] | None
    judge: Callable[[Answer], Verdict]

    def recorded(self) -> Path:
        """Its folder, recorded anew if it is not whole. Raises what a case raises that cannot be
        played.
        """
        if self.record is not None and not self.last.exists():
            for folder in {self.folder, self.last.parent}:
                rmtree(folder, ignore_errors=True)
            self.record()
        return self.folder


def kept(folder: Path, seed: int, real: Path | None) -> list[Kept]:
    """All of them, the kinds in turn, so that the first hundred hold all of them.

    folder: gets plain/ and rough/, as a sealed trial leaves them, and station/. seed: of the
    trials. real: with real/, rough/ and field/.
    """
    kinds = [
        _plain(folder / "plain", seed), _rough(folder / "rough", seed), _station(folder / "station")
    ]  # fmt: skip
    if real is not None:
        kinds.append(_real(real))
    turns = chain.from_iterable(zip_longest(*kinds))
    return [one for one in turns if one is not None]


def _plain(folder: Path, seed: int) -> Iterator[Kept]:
    """Of the sealed trial one of each effect and size, as short as its procedure can be."""
    chosen = Counter[tuple[str, tuple[str, ...], float | None]]()
    for drawn in draw(seed):
        effects = tuple(call.name for call in drawn.case.effects)
        key = drawn.kind, effects if drawn.kind in ("single", "outside") else (), drawn.z
        chosen[key] += 1
        if chosen[key] > MOST_OF.get(drawn.kind, 1):
            continue
        rate = min(drawn.case.rate_hz, MOST_RATE)
        case = drawn.case.model_copy(update={"rate_hz": rate, "dwell_s": min(DWELLS)})
        short = drawn.model_copy(update={"case": case})
        yield _of_trial("sealed", drawn.label, folder, partial(record_and_seal, short), _by_plain)


def _rough(folder: Path, seed: int) -> Iterator[Kept]:
    for drawn in draw_rough(seed):
        record = partial(record_and_seal_rough, drawn)
        yield _of_trial("rough", drawn.label, folder, record, _by_rough)


def _of_trial(
    kind: str,
    label: str,
    folder: Path,
    record: Callable[[Path], None],
    judge: Callable[[Path, Answer], Verdict],
) -> Kept:
    sealed = folder / SEALED / label
    return Kept(
        kind, label, folder / RECORDINGS / label, sealed / "trial.json",
        partial(record, folder), partial(judge, sealed),
    )  # fmt: skip


def _by_plain(sealed: Path, answer: Answer) -> Verdict:
    declared = _json(sealed / "truth.json")
    true = set(declared["effects"])
    truth = Truth(declared["effects"], declared["parameters"], declared["case"])
    pairs = [
        pair
        for one in answer["findings"]
        if one["effect"] in true and not one["effect"].startswith("x_")
        for pair in compared(truth, one["effect"], one["parameters"])[0]
    ]
    return by_names(answer, true, (sum(pair.inside for pair in pairs), len(pairs)))


def _by_rough(sealed: Path, answer: Answer) -> Verdict:
    declared, trial = _json(sealed / "truth.json"), _json(sealed / "trial.json")
    score = scored_rough(sealed.name, declared, trial, dict(answer), 0.0)
    wrong = [*score.wrong]
    right = [name for name in score.names if name != station.UNNAMED and name not in wrong]
    inside = sum(pair.inside for pair in score.parameters)
    return Verdict(tuple(right), tuple(wrong), inside, len(score.parameters))


def _station(folder: Path) -> Iterator[Kept]:
    for number, case in enumerate(cases(STATION_CASES), start=1):
        own = folder / f"{number:03d}"
        yield Kept(
            "station", own.name, own, own / "manifest.json", partial(_record, case, own),
            partial(_by_station, case),
        )  # fmt: skip


def _record(case: Case, folder: Path) -> None:
    write(recording_of(case), folder)


def _by_station(case: Case, answer: Answer) -> Verdict:
    score = station.score(case, {**answer, "seconds": 0.0})
    named = [one["effect"] for one in answer["findings"] if one["effect"] != station.UNNAMED]
    right = [name for name in named if name not in score.wrong]
    stated = [each for each in (score.low_pass, score.delay) if each != "absent"]
    return Verdict(
        tuple(right), score.wrong, sum(each in ("right", "group") for each in stated), len(stated)
    )


def _real(folder: Path) -> Iterator[Kept]:
    for kind in ("rough", "field", "real"):
        for manifest in sorted((folder / kind).glob("*/manifest.json")):
            own, judge = manifest.parent, partial(_by_known, manifest.parent.name)
            yield Kept(f"real: {kind}", own.name, own, manifest, None, judge)


def _by_known(name: str, answer: Answer) -> Verdict:
    if name in TRUE_OF:
        return by_names(answer, TRUE_OF[name])
    findings = [
        {**one, "follows": one["follows"] and {"en": one["follows"]}} for one in answer["findings"]
    ]
    claims = judged(name, {**answer, "findings": findings}, KNOWN, [])
    say = {word: tuple(one.response.split()[0].rstrip(":") for one in claims
                       if one.judgement == word) for word in ("right", "wrong")}  # fmt: skip
    return Verdict(say["right"], say["wrong"])


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


# What each rule moves, as a table.

COLUMNS = (
    "rule", "what it is for", "recordings", "where it acts", "right names gained / lost without it",
    "wrong names gained / lost", "other groups", "other intervals",
    "intervals that hold the truth, with / without", "for example",
)  # fmt: skip
MOVED = 0.05  # of u: an interval that changes by less is the same
EXAMPLES = 3
Row = Mapping[str, Any]


@dataclass
class Counted:
    """What a switch moves, over recordings. inside: intervals that hold the truth, with and
    without the rule, and how many of each are stated.
    """

    asked: int = 0
    acted: int = 0
    right_gained: int = 0
    right_lost: int = 0
    wrong_gained: int = 0
    wrong_lost: int = 0
    groups: int = 0
    intervals: int = 0
    inside: tuple[int, int] = (0, 0)
    stated: tuple[int, int] = (0, 0)
    failed: int = 0
    examples: tuple[str, ...] = ()

    @property
    def moves(self) -> bool:
        return any((self.right_gained, self.right_lost, self.wrong_gained, self.wrong_lost,
                    self.groups, self.intervals, self.failed))  # fmt: skip


def counted(rows: Iterable[Row], name: str) -> Counted:
    """What a switch of this name moves."""
    total = Counted()
    for row in rows:
        if "failed" in row or name not in row["asked"]:
            continue
        total.asked += 1
        if name not in row["without"]:
            continue
        total.acted += 1
        _add(total, row, row["without"][name])
    return total


def _add(total: Counted, row: Row, other: Row) -> None:
    if "failed" in other:
        total.failed += 1
        return
    before, after = row["judged"], other.get("judged", row["judged"])
    gained = {say: Counter(after[say]) - Counter(before[say]) for say in ("right", "wrong")}
    lost = {say: Counter(before[say]) - Counter(after[say]) for say in ("right", "wrong")}
    total.right_gained += gained["right"].total()
    total.right_lost += lost["right"].total()
    total.wrong_gained += gained["wrong"].total()
    total.wrong_lost += lost["wrong"].total()
    answer = other.get("answer", row["answer"])
    total.groups += _groups(row["answer"]) != _groups(answer)
    total.intervals += not _same_intervals(row["answer"], answer)
    total.inside = total.inside[0] + before["inside"], total.inside[1] + after["inside"]
    total.stated = total.stated[0] + before["stated"], total.stated[1] + after["stated"]
    marks = [
        f"{sign}{name}{'!' if say == 'wrong' else ''}"
        for sign, by_say in (("+", gained), ("−", lost))
        for say, names in by_say.items()
        for name in names.elements()
    ]
    if marks and len(total.examples) < EXAMPLES:
        total.examples += (f"{row['kind']} {row['label']}: {', '.join(marks)}",)


def _groups(answer: Row) -> list[Any]:
    return sorted(
        (one["effect"], sorted(one["group"]), sorted(one["indistinguishable_from"]))
        for one in answer["findings"]
        if one["effect"] != "unnamed"
    )


def _same_intervals(one: Row, other: Row) -> bool:
    first, second = _intervals(one), _intervals(other)
    return all(
        abs(first[key][0] - second[key][0]) <= MOVED * first[key][1]
        and abs(first[key][1] - second[key][1]) <= MOVED * first[key][1]
        for key in first.keys() & second.keys()
    )


def _intervals(answer: Row) -> dict[tuple[str, str], tuple[float, float]]:
    return {
        (one["effect"], each["name"]): (each["value"], each["u"])
        for one in answer["findings"]
        if one["effect"] != "unnamed"
        for each in one["parameters"]
        if each["u"] > 0.0
    }


def markdown(rows: Sequence[Row], purposes: Mapping[str, str]) -> str:
    """The table, a row for each rule. purposes: of each, by its name."""
    size = counts()
    answered = [row for row in rows if "failed" not in row]
    kinds = Counter(row["kind"] for row in answered)
    names = Counter[str]()
    for row in answered:
        for say in ("right", "wrong"):
            names[say] += len(row["judged"][say])
    lines = [
        "# Each rule of `explain` switched off in turn", "",
        f"{len(answered)} recordings: {', '.join(f'{n} {kind}' for kind, n in kinds.items())}; "
        f"{len(rows) - len(answered)} could not be read. With all rules: {names['right']} right "
        f"names, {names['wrong']} wrong ones. A rule acts where any of its outcomes would differ "
        "without it; ! marks a wrong name.", "",
        f"The engine has {size.lines} lines without blanks, {size.constants} numeric constants of "
        f"modules and {size.names} literal names of effects outside of the files that find events, "
        f"in {size.files} files.", "",
        *table(COLUMNS, (
            (name, why, *_cells(counted(rows, name))) for name, why in purposes.items()
        )), "",
    ]  # fmt: skip
    return "\n".join(lines)


def _cells(each: Counted) -> list[str]:
    if not each.acted:
        moved = ["0", *["–"] * 6]
    else:
        moved = [
            f"{each.acted}" + (f", fails in {each.failed}" if each.failed else ""),
            f"{each.right_gained} / {each.right_lost}",
            f"{each.wrong_gained} / {each.wrong_lost}",
            f"{each.groups}",
            f"{each.intervals}",
            " / ".join(f"{a} of {b}" for a, b in zip(each.inside, each.stated, strict=True)),
            "; ".join(each.examples),
        ]
    return [f"{each.asked}", *moved]


# Runs the names of kept recordings without each rule; `page` makes the table of it.

SWITCHES = (*EVIDENCE, *COMPARISONS)
PURPOSES = {one.name: one.purpose for one in SWITCHES} | {
    name: ", ".join(members) for name, members in TOGETHER.items()
}
SELECTION, EXPLANATION = "selection", "explanation"
LONGEST = 60.0  # s of processor time on one recording: after it no other rule is switched off
# What errors of the reference make is drawn anew only where a rule may change it.
DRAWN_ANEW = ("evidence.reference_errors", "evidence.scatter", "evidence.evidence")


def ablation(
    real: Real = None, seed: Seed = 1, out: Out = None, minutes: Minutes = None,
    write: Write = False,
) -> None:  # fmt: skip
    """Names on kept recordings without each rule of `explain` in turn.

    Short trials and the station are recorded in the folder; --real: with real/, rough/ and field/.
    """
    folder = folder_of("ablation", out)
    work = {
        re.sub(r"\W+", "-", f"{seed}-{one.kind}-{one.label}"): one
        for one in kept(folder, seed, real)
    }
    hold("ablation", work, _ablated, partial(markdown, purposes=PURPOSES), out, minutes=minutes,
         write=write)  # fmt: skip


def _ablated(one: Kept) -> dict[str, Any]:
    """The answer with all rules, and of each that acts there the one without it, judged."""
    started = time.process_time()
    row: dict[str, Any] = {"kind": one.kind, "label": one.label}
    number = crc32(f"{one.kind} {one.label}".encode())
    switches = [each for each in SWITCHES if number % each.every == 0]
    row["asked"] = [*(each.name for each in switches), *TOGETHER]
    try:
        prepared = prepare(read_folder(one.recorded()), delay_sought=True)
        begun = time.process_time()
        found = searched(prepared)
    except Exception as failure:  # an answer, too
        return row | {"failed": f"{type(failure).__name__}: {failure}"}
    row["seconds"] = [begun - started, time.process_time() - begun]
    watch, drawn = Watch(switches), _Remembered()
    with watch.on(), drawn.on():
        watch.stage = SELECTION
        evidence = explain._selected(found, silent)
        watch.stage = EXPLANATION
        answer = response(assemble.explanation_of(prepared, evidence))
    row["answer"], row["judged"] = answer, asdict(one.judge(answer))
    row["seconds"].append(time.process_time() - begun - row["seconds"][1])
    row["without"] = {}
    for name, some in _to_try(switches, watch):
        if time.process_time() - started > LONGEST:
            row["asked"].remove(name)
            continue
        stages = set[str]().union(*(watch.acted[each.name] for each in some))
        with ExitStack() as without:
            if all(map(_remembers, some)):  # below what is switched off
                without.enter_context(drawn.on())
            for each in some:
                without.enter_context(off(each))
            other = _answered(prepared, found, evidence, stages)
        if isinstance(other, str):
            row["without"][name] = {"failed": other}
        elif other == answer:
            row["without"][name] = {}
        else:
            row["without"][name] = {"answer": other, "judged": asdict(one.judge(other))}
    return row | {"spent": time.process_time() - started}


def _to_try(switches: Sequence[Switch], watch: Watch) -> Iterator[tuple[str, list[Switch]]]:
    """Each switch that acts, and together those that make up for one another."""
    acting = {each.name: each for each in switches if each.name in watch.acted}
    yield from ((name, [each]) for name, each in acting.items())
    for name, members in TOGETHER.items():
        some = [acting[member] for member in members if member in acting]
        if len(some) > 1:
            yield name, some


def _answered(
    prepared: Prepared, found: Searched, evidence: Evidence, stages: set[str]
) -> dict[str, Any] | str:
    """The answer from the stage on in which the rule acts; a failure by what it says."""
    try:
        if SELECTION in stages:
            evidence = explain._selected(found, silent)
        else:  # what it keeps in mind was worked out by the rule
            evidence = replace(evidence, scatter=replace(evidence.scatter))
        return response(assemble.explanation_of(prepared, evidence))
    except Exception as failure:
        return f"{type(failure).__name__}: {failure}"


def response(explanation: Explanation) -> dict[str, Any]:
    """What an answer says, as far as rules may change it."""
    return {
        "verdict": explanation.verdict,
        "findings": [
            {
                "effect": one.effect,
                "group": list(one.group),
                "indistinguishable_from": list(one.indistinguishable),
                "refused": one.refusal and [one.refusal.kind, one.refusal.name],
                "channels": list(one.channels),
                "share": round(one.share, 3),
                "parameters": [each.model_dump() for each in one.parameters],
                "common": [each.model_dump() for each in one.common],
                "follows": None,
            }
            for one in explanation.findings
        ],
        "small": sorted(one.effect for one in explanation.small),
    }


def _remembers(switch: Switch) -> bool:
    return switch.attribute.partition(":")[0] not in DRAWN_ANEW


class _Remembered:
    """The two dearest steps of an explanation, worked out once for the same input."""

    def __init__(self) -> None:
        self._noise: dict[int, tuple[FittedSelection, set[int]]] = {}
        self._events: dict[bytes, Events] = {}

    @contextmanager
    def on(self) -> Iterator[None]:
        drawn, found = assemble.fitted_to_reference_noise, assemble.events_in_residual

        def by_fit(prepared: Prepared, standard: Model, evidence: Evidence) -> set[int]:
            if id(evidence.fit) not in self._noise:
                self._noise[id(evidence.fit)] = evidence.fit, drawn(prepared, standard, evidence)
            return self._noise[id(evidence.fit)][1]

        def by_residual(
            events: Events, residual: np.ndarray, noise: np.ndarray, motion: Motion,
            start: float = 0.0,
        ) -> Events:  # fmt: skip
            key = blake2b(residual.tobytes()).digest()
            if key not in self._events:
                self._events[key] = found(events, residual, noise, motion, start)
            return self._events[key]

        assemble.fitted_to_reference_noise = by_fit
        assemble.events_in_residual = by_residual
        try:
            yield
        finally:
            assemble.fitted_to_reference_noise, assemble.events_in_residual = drawn, found
