"""Recordings handed out, their truth sealed elsewhere, and the seals: a SHA-256 for each file."""

import hashlib
import json
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, Protocol, TypeVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO
from tests.proof.plant.case import Case, Data, EffectCall, Noise, channel_noise
from tests.proof.plant.effects import CATALOGUE, OUTSIDE
from tests.proof.plant.simulate import Simulated, at_visibility, seal, simulate, visibility, write
from tests.proof.study import answers
from tests.proof.trial.blind import RECORDINGS, certificate_of

# Which cases a trial has: drawn from its seed, nothing chosen by hand.

Kind = Literal["clean", "single", "faint", "several", "outside"]

ABSORBED = "gravity_value"  # the accelerometers' scale factors take it whole: it cannot be told
OF_ITS_OWN = ("earth_rotation", ABSORBED)  # sizes that no strength may change
SIZED = tuple(name for name in CATALOGUE if name not in OF_ITS_OWN)
TYPICAL = 1.0  # g differs by 0.5 to 2 mm/s² then
STRENGTHS = (10.0, 30.0, 100.0)  # z asked of an effect alone
OUTSIDE_STRENGTHS = (30.0, 100.0)
FAINT = 5.0  # z at which the limit of any detector is near 1 but not yet there
TOGETHER = 40.0  # z of each effect of several
NEEDS_THERMOMETER = ("temperature_bias", "temperature_scale", "thermal_gradient")

# how often each procedure is drawn; `partial` is three_axis with few rates
PROCEDURES = {
    "three_axis": 0.47, "single_axis": 0.15, "six_orientations": 0.12, "one_axis": 0.08,
    "rests": 0.05, "partial": 0.08, "ahrs": 0.05,
}  # fmt: skip
RATES = ((10.0, 50.0, 100.0, 200.0, 300.0), (20.0, 60.0, 150.0, 250.0), (50.0, 100.0, 300.0, 400.0))
FEW_RATES = ((50.0, 200.0), (30.0, 120.0), (300.0,))
DWELLS = (12.0, 16.0, 20.0, 30.0)  # s
MOST_ROWS = 110_000  # so that a case is explained within 8 s
# dwells: fixed ones, and for each rate
SEGMENTS = {"three_axis": (18, 6), "single_axis": (18, 6), "six_orientations": (12, 12),
        "one_axis": (2, 2), "rests": (12, 0), "ahrs": (22, 6)}  # fmt: skip
TURNING = {"ahrs": 300.0}  # s that no dwell makes shorter: ten turns, three axes, both ways
CLEAN = 120  # recordings without effects: as many as false alarms of 1 % ask for at the least


class Drawn(Data):
    """A case as drawn. z: asked of each effect; None: its size is what it is."""

    number: int
    kind: Kind
    case: Case
    z: float | None = None

    @property
    def label(self) -> str:
        """“0007”, the name of its folders: it tells nothing."""
        return f"{self.number:04d}"


Ask = tuple[Kind, tuple[str, ...], float | None]


def draw(seed: int, short: bool = False) -> list[Drawn]:
    """The cases of a trial, in an order that tells nothing. At least a fifth of them is clean."""
    rng = np.random.default_rng([seed, 5])
    asked = list(_short(rng) if short else _full(rng))
    asked += [("clean", (), None)] * (-(-len(asked) // 4) if short else CLEAN)
    order = rng.permutation(len(asked))
    return [
        Drawn(number=n, kind=asked[i][0], case=conditions(rng, asked[i]), z=asked[i][2])
        for n, i in enumerate(order, start=1)
    ]


def _full(rng: np.random.Generator) -> Iterator[Ask]:
    for name in SIZED:
        for z in STRENGTHS:
            for _ in range(2):
                yield "single", (name,), z
        yield "faint", (name,), FAINT
    for name in ("earth_rotation",) * 6 + (ABSORBED,) * 4:
        yield "single", (name,), None
    for name in OUTSIDE:
        yield from (("outside", (name,), z) for z in OUTSIDE_STRENGTHS)
    yield from (_several(rng, 2) for _ in range(24))
    yield from (_several(rng, 3) for _ in range(12))


def _short(rng: np.random.Generator) -> Iterator[Ask]:
    """A few of each kind, spread over the catalogue."""
    for k, name in enumerate(rng.choice(SIZED, 14, replace=False)):
        yield "single", (str(name),), STRENGTHS[k % 3]
    yield "faint", (str(rng.choice(SIZED)),), FAINT
    yield "single", ("earth_rotation",), None
    yield "single", (ABSORBED,), None
    for k, name in enumerate(rng.choice(OUTSIDE, 4, replace=False)):
        yield "outside", (str(name),), OUTSIDE_STRENGTHS[k % 2]
    yield from (_several(rng, 2) for _ in range(2))
    yield _several(rng, 3)


def _several(rng: np.random.Generator, count: int) -> Ask:
    together = [name for name in CATALOGUE if name != ABSORBED]
    return "several", tuple(map(str, rng.choice(together, count, replace=False))), TOGETHER


def conditions(rng: np.random.Generator, ask: Ask, procedure: str | None = None) -> Case:
    """A case with these effects at typical size, its unit, station and procedure drawn."""
    kind, effects, _ = ask
    names = list(PROCEDURES)
    drawn = procedure or str(rng.choice(names, p=list(PROCEDURES.values())))
    if kind == "outside" and drawn == "ahrs":  # nothing there moves to a position, as some need
        drawn = "three_axis"
    declared: dict[str, Any] = {
        "seed": int(rng.integers(1, 1_000_000)),
        "grade": str(rng.choice(["consumer", "industrial", "tactical"])),
        "procedure": "three_axis" if drawn == "partial" else drawn,
        "rate_hz": int(rng.choice([100, 50, 200], p=[0.7, 0.15, 0.15])),
        "order": str(rng.choice(["rising", "alternating", "shuffled"])),
        "climate": str(rng.choice(["room", "cycling"], p=[0.7, 0.3])),
        "latitude_deg": round(float(rng.uniform(-50.0, 60.0)), 2),
        "heading_deg": float(rng.choice([0.0, round(rng.uniform(-180.0, 180.0), 1)])),
        "gravity_m_s2": round(float(rng.uniform(9.781, 9.825)), 4),
        "effects": tuple(EffectCall(name=name, strength=TYPICAL) for name in effects),
    }
    if drawn == "ahrs":  # its turns alone would fill a run at the highest rate
        declared["rate_hz"] = min(declared["rate_hz"], 100)
    few = drawn == "partial" or declared["rate_hz"] == 200
    choices = FEW_RATES if few else RATES
    declared["rates_deg_s"] = choices[int(rng.integers(len(choices)))]
    declared["dwell_s"] = _dwell(float(rng.choice(DWELLS)), declared)
    # What no thermometer recorded cannot be named after it; a warm-up can.
    unrecorded = 0.5 if "thermal_transient" in effects else 0.15
    needed = any(name in NEEDS_THERMOMETER for name in effects)
    declared["temperature_recorded"] = needed or bool(rng.uniform() > unrecorded)
    # Where the site is not told, level directions are the table's: no name of the catalogue
    # loses its parameters for that in a trial that compares them.
    declared["site_known"] = kind not in ("clean", "outside") or bool(rng.uniform() > 0.15)
    return Case(**declared)


def _dwell(drawn: float, declared: dict[str, Any]) -> float:
    """The longest dwell up to the one drawn that keeps the run short enough."""
    fixed, for_each = SEGMENTS[declared["procedure"]]
    segments = fixed + for_each * len(declared["rates_deg_s"])
    seconds = MOST_ROWS / declared["rate_hz"] - TURNING.get(declared["procedure"], 0.0)
    longest = seconds / segments - 4.0
    return max(min(drawn, float(np.floor(longest))), min(DWELLS))


# What noise alone makes of the standard's parameters: nobody who has to fit them is nearer.


def floor_of(clean: Simulated) -> float:
    """Σ over channels of |error|²/σ² of models (1) and (2), fitted to a case without effects.

    The fit weighs by the inverse of the true noise spectrum; σ is the grade's white noise. It is
    about the number of parameters, and with flicker noise many times that.
    """
    case = clean.case
    noise = clean.recording.imu.stack(GYRO + ACCEL) - clean.truth
    rates, force = clean.reported[:, :3], clean.reported[:, 3:]
    one = np.ones((len(rates), 1))
    total = 0.0
    for channel, model in enumerate(channel_noise(case.grade)):
        beside = np.delete(rates, channel - 3, axis=1) ** 2 if channel >= 3 else rates
        columns = np.hstack([force, one, beside])
        columns = columns[:, (columns**2).mean(axis=0) > 0.0]
        white = _whitened(np.column_stack([columns, noise[:, channel]]), model, case.rate_hz)
        found, *_ = np.linalg.lstsq(white[:, :-1], white[:, -1], rcond=1e-10)
        error = columns @ found / (model.white * np.sqrt(case.rate_hz / 2.0))
        total += float(error @ error)
    return total


def _whitened(courses: np.ndarray, model: Noise, rate: float) -> np.ndarray:
    """Courses (n, k) divided by the root of the noise spectrum; ends are mirrored."""
    count = len(courses)
    length = next_fast_len(2 * count, real=True)
    frequency = rfftfreq(length, 1.0 / rate)
    frequency[0] = frequency[1] / 2.0
    gain = np.sqrt(model.density(frequency))[:, None]
    mirrored = np.pad(courses, ((0, length - count), (0, 0)), mode="symmetric")
    return np.asarray(irfft(rfft(mirrored, axis=0) / gain, length, axis=0)[:count])


SEALED, SEALS, DRAWN = "sealed", "seals.txt", "drawn.json"


def record_and_seal(drawn: Drawn, folder: Path) -> None:
    """Sizes and plays one case: its recording, and apart from it its truth.

    Writes recordings/<number>/ and sealed/<number>/ with truth.json, truth.parquet and
    trial.json: kind, z asked, z and concealment of each effect as they came out, the floor
    that noise alone sets to the misfit, and the certificate of the same run without effects.
    """
    case = sized(drawn)
    simulated = simulate(case)
    observation = {call.name: visibility(simulated, call.name) for call in case.effects}
    write(simulated.recording, folder / RECORDINGS / drawn.label)
    sealed = folder / SEALED / drawn.label
    seal(simulated.recording, simulated.sealed, simulated.truth, sealed)
    clean = simulate(case.only())
    declared = {
        "kind": drawn.kind,
        "asked_z": drawn.z,
        "z": {name: each.z for name, each in observation.items()},
        "concealment": {name: each.concealment for name, each in observation.items()},
        "floor": floor_of(clean),
        "certificate": certificate_of(clean.recording),
    }
    (sealed / "trial.json").write_text(json.dumps(declared, indent=1), encoding="utf-8")


def sized(drawn: Drawn) -> Case:
    """The case with each effect at the z asked of it.

    An effect that the drawn procedure cannot have or show is played on three axes with every
    rate; what the standard absorbs there, too, keeps its typical size.
    """
    if drawn.z is None:
        return drawn.case
    try:
        return _at(drawn.case, drawn.z)
    except ValueError:
        case = _on_three_axes(drawn)
    try:
        return _at(case, drawn.z)
    except ValueError:
        return case


def _at(case: Case, z: float) -> Case:
    for call in case.effects:
        case = at_visibility(case, call.name, z)
    return case


def _on_three_axes(drawn: Drawn) -> Case:
    rng = np.random.default_rng([drawn.case.seed, 7])
    effects = tuple(call.name for call in drawn.case.effects)
    case = conditions(rng, (drawn.kind, effects, drawn.z), "three_axis")
    return case.model_copy(update={"temperature_recorded": True})


def set_seals(folder: Path) -> str:
    """Writes seals.txt, as `sha256sum -c` reads it; returns the SHA-256 of seals.txt itself."""
    files = sorted(path for path in (folder / SEALED).rglob("*") if path.is_file())
    lines = [f"{digest_of(path)}  {path.relative_to(folder).as_posix()}\n" for path in files]
    (folder / SEALS).write_text("".join(lines), encoding="utf-8")
    return digest_of(folder / SEALS)


def check_seals(folder: Path) -> None:
    """Raises Unusable where a sealed file is missing, was changed or came later."""
    sealed: dict[str, str] = {}
    for line in (folder / SEALS).read_text(encoding="utf-8").splitlines():
        digest, _, name = line.partition("  ")
        sealed[name] = digest
    there = {
        path.relative_to(folder).as_posix(): path
        for path in (folder / SEALED).rglob("*")
        if path.is_file()
    }
    for name in sorted(sealed.keys() | there.keys()):
        if name not in there or digest_of(there[name]) != sealed.get(name):
            raise Unusable(
                f"{folder / name} is not what was sealed in {folder / SEALS}; this trial proves "
                "nothing any more: hold it again in a new folder"
            )


def digest_of(path: Path) -> str:
    """SHA-256 (hex) of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Labelled(Protocol):
    """Something with a label, the name of its folders."""

    @property
    def label(self) -> str: ...


Work = TypeVar("Work", bound=Labelled)


def sealed(
    folder: Path, declared: Mapping[str, Any], cases: Sequence[Work],
    record: Callable[[Work, Path], None],
) -> str:  # fmt: skip
    """Records and seals every case, and goes on where that broke off; the SHA-256 of seals.txt.

    declared: what tells one trial from another. record: plays one case, its recording and its truth
    to the folder. Raises Unusable for a folder that is in use or holds another trial, and for seals
    that are broken.
    """
    drawn = folder / DRAWN
    if drawn.exists():
        if json.loads(drawn.read_text(encoding="utf-8")) != declared:
            raise Unusable(f"--out {folder} holds another trial; name a folder of its own")
    elif any(folder.iterdir()):
        raise Unusable(f"--out {folder} is not empty; a trial needs a folder of its own")
    drawn.write_text(json.dumps(declared), encoding="utf-8")
    if (folder / SEALS).exists():
        check_seals(folder)
        return digest_of(folder / SEALS)
    work = {each.label: each for each in cases}
    answers("record and seal", work, partial(_recorded, record, folder), folder)
    return set_seals(folder)


def _recorded(record: Callable[[Work, Path], None], folder: Path, drawn: Work) -> None:
    for room in (RECORDINGS, SEALED):
        shutil.rmtree(folder / room / drawn.label, ignore_errors=True)
    record(drawn, folder)
