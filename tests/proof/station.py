"""What a recording of the virtual station is made of: a unit, its filters, its clock, a run."""

import asyncio
import json
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import islice, product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from schemas.procedure import Procedure
from schemas.recording import Recording, Stream
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from tasks.station import procedures
from tasks.station.clock import wall_s
from tasks.station.ports import EncoderBlock, TableState
from tasks.station.virtual.config import STEP_S, VirtualStation, virtual_station
from tasks.station.virtual.simulation import Simulation
from tests.proof.plant.simulate import write
from tests.proof.study import Count, Out, Write, answers, folder_of, publish, table
from tests.proof.trial.blind import ANSWER, ANSWERS, RECORDINGS, explain_blind
from tests.tasks.station.in_memory import InMemoryStation, InMemoryTable

ProcedureName = Literal["jjf2003", "jjf1536"]
PROCEDURES: tuple[ProcedureName, ...] = ("jjf2003", "jjf1536")
CORNERS_HZ = (15.0, 80.0)
DELAYS_S = (1e-3, 2e-2)
NO_FILTER_HZ = 0.499 / STEP_S  # half the plant's rate, as nearly as a digital filter has it
SEEDS = 20


@dataclass(frozen=True)
class Case:
    """seed: of the unit, its corners and its delay; which of low-pass and delay it has.

    is_loaded: whether the computer that records is busy with other work, too.
    """

    seed: int
    procedure: ProcedureName
    has_low_pass: bool
    has_delay: bool
    is_loaded: bool = False

    @property
    def name(self) -> str:
        parts = [name for name, has in (("low-pass", self.has_low_pass),
                                        ("delay", self.has_delay)) if has]  # fmt: skip
        loaded = "-loaded" if self.is_loaded else ""
        return f"{self.procedure}-{self.seed:02d}-{'+'.join(parts) or 'neither'}{loaded}"

    @property
    def corners_hz(self) -> tuple[float, float] | None:
        """Of gyros and of accelerometers, second-order Butterworth."""
        low, high = np.log(CORNERS_HZ)
        gyro, accel = np.exp(self._rng(1).uniform(low, high, 2)).tolist()
        return (gyro, accel) if self.has_low_pass else None

    @property
    def delay_s(self) -> float:
        """By which the unit's stamps are late; early where negative."""
        rng = self._rng(2)
        return float(rng.uniform(*DELAYS_S) * rng.choice((-1.0, 1.0))) if self.has_delay else 0.0

    @property
    def group_delays_s(self) -> tuple[float, float]:
        """Of gyros and accelerometers at low frequency: the clock's and √2·T of a filter."""
        gyro, accel = (self.delay_s + float(np.sqrt(2.0)) * T for T in self.time_constants_s)
        return gyro, accel

    @property
    def time_constants_s(self) -> tuple[float, float]:
        """1/(2πf) of gyros and accelerometers; nothing without a filter, as an AHRS's gyros are.

        The station's filter is digital: at low frequency it acts as the analogue one from which
        the bilinear transform makes it, whose corner is 2/h·tan(π·f·h)/(2π).
        """
        if self.corners_hz is None:
            return 0.0, 0.0
        gyro, accel = (0.5 * STEP_S / float(np.tan(np.pi * hz * STEP_S)) for hz in self.corners_hz)
        return (0.0 if self.procedure == "jjf1536" else gyro), accel

    @cached_property
    def station(self) -> VirtualStation:
        """The virtual station with this unit."""
        drawn = virtual_station(self.seed, ahrs=self.procedure == "jjf1536")
        corners = self.corners_hz or (NO_FILTER_HZ, NO_FILTER_HZ)
        triads = {
            name: getattr(drawn.unit, name).model_copy(update={"bandwidth_hz": hz})
            for name, hz in zip(("gyro", "accel"), corners, strict=True)
        }
        return drawn.model_copy(update={"unit": drawn.unit.model_copy(update=triads)})

    def _rng(self, purpose: int) -> np.random.Generator:
        return np.random.default_rng(np.random.SeedSequence((self.seed, 40 + purpose)))


def cases(count: int) -> tuple[Case, ...]:
    """The first so many of 160: each unit with both, one or neither, by one procedure or the other.

    In the first eighty every condition has both procedures in turn, and each of these a busy
    computer every other time; then procedures and computers change places.
    """
    conditions = tuple(product((True, False), repeat=2))
    every = (
        Case(seed, procedure, low_pass, delay, (seed // 2 + k + turn) % 2 == 0)
        for turn in range(2)
        for seed in range(1, SEEDS + 1)
        for k, (low_pass, delay) in enumerate(conditions)
        for procedure in [PROCEDURES[(seed + k + turn) % 2]]
    )
    return tuple(islice(every, count))


# A virtual station whose computer is busy with other work: its answers come late, in bouts.
#
# The table and the unit stamp what they send, so that lateness moves no stamp. But encoder
# samples are fetched, block after block over one link, from a ring that holds the newest: a
# client that is kept waiting falls behind, loses what is overwritten, and at the end has not
# fetched the last.

BOUT_S = 0.4  # wall time that the computer is busy, and then is not, on average
LATE_S = 0.01  # that an answer takes on average where it is busy


class BusyTable(InMemoryTable):
    """Answers one request after another, as over one link."""

    def __init__(self, simulation: Simulation, rng: np.random.Generator) -> None:
        super().__init__(simulation)
        self._rng = rng
        self._link = asyncio.Lock()
        self._is_busy = bool(rng.integers(2))
        self._until_s = 0.0

    async def state(self) -> TableState:
        async with self._link:
            await self._wait()
            return await super().state()

    async def encoder(self, first: int) -> EncoderBlock:
        async with self._link:
            await self._wait()
            return await super().encoder(first)

    async def _wait(self) -> None:
        while wall_s() > self._until_s:
            self._is_busy = not self._is_busy
            self._until_s += self._rng.exponential(BOUT_S)
        if self._is_busy:
            await asyncio.sleep(self._rng.exponential(LATE_S))


class BusyStation(InMemoryStation):
    """seed: of when it is busy, and for how long."""

    def __init__(self, config: VirtualStation, speed: float, seed: int) -> None:
        super().__init__(config, speed)
        rng = np.random.default_rng(np.random.SeedSequence((seed, 50)))
        self.table = BusyTable(self.simulation, rng)


# A recording of the virtual station, in simulated time: the procedure with short dwells.

DWELL_S, WARM_UP_S = 4.0, 5.0
SPEED = 200.0  # station seconds in a second of the simulated wall clock


def recording_of(case: Case) -> Recording:
    """Acquired by way of a raw file, as a run is; then its stamps are moved by the delay."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        with RawWriter(path) as sink:
            _station(case).acquire(shortened(case.procedure), sink)
        made = read_mcap(path)
    stamps = np.round(made.imu.t + case.delay_s, 9)
    name = f"station_{case.name}"
    manifest = made.manifest.model_copy(update={"recording_id": name})
    return replace(made, manifest=manifest, imu=Stream(stamps, made.imu.columns))


def _station(case: Case) -> InMemoryStation:
    if case.is_loaded:
        return BusyStation(case.station, SPEED, case.seed)
    return InMemoryStation(case.station, SPEED)


def shortened(name: str) -> Procedure:
    values = procedures.load(name).model_dump()
    steps = [
        step | ({"dwell_s": min(step["dwell_s"], DWELL_S)} if "dwell_s" in step else {})
        for step in values["steps"]
    ]
    return Procedure.model_validate(values | {"steps": steps, "warm_up_s": WARM_UP_S})


# What an answer about a recording of the virtual station is worth.

UNNAMED = "unnamed"
LOW_PASS, DELAY = "bandwidth", "time_offset"
# What is true of every unit of the station: its accelerometers sit beside the axes, its biases
# follow its temperature, and the Earth turns.
ALWAYS = ("lever_arm", "size_effect", "temperature_bias", "earth_rotation")
WITHIN = 3.0  # standard uncertainties
NEGLIGIBLE_S = 1e-4  # that a value may be off by all the same
Judged = Literal["right", "group", "not told", "wrong value", "absent", "invented"]
Finding = Mapping[str, Any]


@dataclass(frozen=True)
class Score:
    """low_pass, delay: how each was told. wrong: names that are not true of the unit."""

    case: Case
    names: tuple[str, ...]
    wrong: tuple[str, ...]
    low_pass: Judged
    delay: Judged
    seconds: float
    failed: str | None

    @property
    def is_silent(self) -> bool:
        """Whether a low-pass or a delay is not told."""
        return "not told" in (self.low_pass, self.delay)

    @property
    def is_right(self) -> bool:
        """No name is wrong, and low-pass and delay are told or cannot be seen."""
        fine = {"right", "group", "absent"}
        filtered = self.low_pass in fine or (self.low_pass == "not told" and _is_hidden(self.case))
        return self.failed is None and not self.wrong and filtered and self.delay in fine


def score(case: Case, answer: Mapping[str, Any]) -> Score:
    """The score of what answer.json says."""
    findings: Sequence[Finding] = answer.get("findings", ())
    named = [one for one in findings if one["effect"] != UNNAMED]
    pairs = ((LOW_PASS, case.has_low_pass), (DELAY, case.has_delay))
    true = {effect for effect, has in pairs if has}
    wrong = [one for one in named if not _is_true(case, one, true)]
    return Score(
        case,
        tuple("/".join(one["group"]) or one["effect"] for one in findings),
        tuple(one["effect"] for one in wrong),
        _declared(LOW_PASS, case, named),
        _declared(DELAY, case, named),
        answer["seconds"],
        answer.get("failed"),
    )


def _is_hidden(case: Case) -> bool:
    """Whether the low-pass is of accelerometers alone that hardly feel a change: those of an AHRS
    upright on a single axis read the same at all angles, ten times a second.
    """
    return case.procedure == "jjf1536"


def _is_true(case: Case, finding: Finding, true: set[str]) -> bool:
    if finding["group"]:
        return not true.isdisjoint(finding["group"]) or not set(ALWAYS).isdisjoint(finding["group"])
    return finding["effect"] in true or (
        finding["effect"] in ALWAYS and _as_large_as_true(case, finding)
    )


def _declared(effect: str, case: Case, named: Sequence[Finding]) -> Judged:
    has = case.has_low_pass if effect == LOW_PASS else case.has_delay
    alone = [one for one in named if one["effect"] == effect and not one["group"]]
    grouped = [one for one in named if effect in one["group"]]
    if grouped:
        right = all(_common_part_is_true(case, one) for one in grouped)
        return ("group" if has else "absent") if right else "wrong value"
    if not has:
        return "invented" if alone else "absent"
    if not alone:
        return "not told"
    true = _times(case) if effect == LOW_PASS else {"seconds": case.delay_s}
    right = all(_agrees(one["parameters"], true) for one in alone)
    return "right" if right else "wrong value"


def _times(case: Case) -> dict[str, float]:
    """Time constants by the names of the effect's parameters, s."""
    gyro, accel = case.time_constants_s
    if np.isclose(gyro, accel, rtol=1e-2):  # one corner for all says it, too
        return {"time_constant": gyro, "gyro_time_constant": gyro, "accel_time_constant": accel}
    return {"gyro_time_constant": gyro, "accel_time_constant": accel}


def _common_part_is_true(case: Case, finding: Finding) -> bool:
    gyro, accel = case.group_delays_s
    true = {"gyro_group_delay": gyro, "accel_group_delay": accel}
    return _agrees(finding["common"], true)


def _agrees(parameters: Sequence[Mapping[str, Any]], true: Mapping[str, float]) -> bool:
    """Whether the parameters that a finding states hold the truth."""
    response = [(p["value"] - true[p["name"]], p["u"]) for p in parameters if p["name"] in true]
    return bool(response) and all(abs(off) <= WITHIN * u + NEGLIGIBLE_S for off, u in response)


def _as_large_as_true(case: Case, finding: Finding) -> bool:
    """Whether a true effect is stated with the size that the unit has it in, to a factor of two."""
    unit = case.station.unit
    largest = {
        "lever_arm": float(np.abs(unit.places_m).max()),
        "size_effect": float(np.abs(unit.places_m).max()),
        "temperature_bias": float(np.abs(unit.accel.bias_per_kelvin).max()),
        "earth_rotation": np.inf,
    }[finding["effect"]]
    return all(abs(p["value"]) <= 2.0 * largest + WITHIN * p["u"] for p in finding["parameters"])


# Makes recordings of the virtual station, has them explained blind, and scores the answers.

MOST = 160
COLUMNS = ("recording", "low-pass", "delay", "wrong names", "told", "s")


def station(count: Count = 80, out: Out = None, write: Write = False) -> None:
    """Short recordings of the virtual station, explained blind: low-pass filters and delays."""
    folder = folder_of("station", out)
    asked = {f"{number:03d}": case for number, case in enumerate(cases(count), start=1)}
    answers("record", asked, partial(_record, folder=folder), folder)
    explain_blind(folder)
    scores = [
        score(case, json.loads((folder / ANSWERS / label / ANSWER).read_text("utf-8")))
        for label, case in asked.items()
    ]
    publish("station", as_markdown(scores), folder, write)


def _record(case: Case, folder: Path) -> None:
    own = folder / RECORDINGS / f"{cases(MOST).index(case) + 1:03d}"
    shutil.rmtree(own, ignore_errors=True)
    write(recording_of(case), own)


def as_markdown(scores: Sequence[Score]) -> str:
    """What came out in all, then a row for each recording."""
    return "\n".join([*summary(scores), "", *table(COLUMNS, map(_row, scores)), ""])


def summary(scores: Sequence[Score]) -> list[str]:
    """Of all recordings: wrong names, and how low-pass and delay were told."""
    lines = [
        f"{len(scores)} recordings of the virtual station: right in "
        f"{sum(one.is_right for one in scores)} "
        f"({sum(one.is_right and one.is_silent for one in scores)} of them by silence, where "
        f"`explain` looks at nothing that would show it), a wrong name in "
        f"{sum(bool(one.wrong) for one in scores)}, failed "
        f"{sum(one.failed is not None for one in scores)}; "
        f"{sum(one.case.is_loaded for one in scores)} by a busy computer."
    ]
    for what in ("low_pass", "delay"):
        declared = Counter(getattr(one, what) for one in scores)
        counts = ", ".join(f"{how} {n}" for how, n in declared.most_common())
        lines.append(f"{what.replace('_', '-')}: {counts}.")
    return lines


def _row(one: Score) -> tuple[str, ...]:
    return (
        _described(one.case), one.low_pass, one.delay, ", ".join(one.wrong) or "none",
        one.failed or ", ".join(one.names) or "nothing", f"{one.seconds:.1f}",
    )  # fmt: skip


def _described(case: Case) -> str:
    corners = " / ".join(f"{hz:.0f}" for hz in case.corners_hz or ())
    return f"{case.name} ({corners or 'no'} Hz, {1e3 * case.delay_s:.1f} ms)"
