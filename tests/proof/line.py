"""A line with years behind it: its units, their runs, results and papers, as a store."""

import hashlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import UTC, date, datetime, timedelta
from hashlib import sha256
from typing import Any

import numpy as np
import sqlalchemy as sql

from schemas.base import Frozen
from schemas.calibration import Calibration
from schemas.certificate import Certificate, Laboratory, Order, Party, Step
from schemas.laboratory import MeasurementStandard
from schemas.recording import ACCEL, GYRO, Manifest, Recording
from schemas.text import Remark
from schemas.tolerance import Decision, Limit, Tolerance
from storage.catalogue import database, equipment, results, runs, tables
from storage.catalogue.results import result_id
from storage.catalogue.runs import unit_id
from storage.formats.manifest import MANIFEST
from storage.home import Home
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.conformity import decide
from tasks.specifications.register import specification_for
from tasks.stages.certify import due_date
from tasks.stages.estimate import estimate
from tests.proof.plant.case import Case, Grade, UnitErrors, channel_noise, draw_unit
from tests.proof.plant.simulate import simulate

STATIONS, YEARS = 6, 3.0
LINE_UNITS = 200  # of a whole line
BEGINNING = datetime(2023, 11, 1, 8, tzinfo=UTC)
MODELS: tuple[tuple[str, Grade], ...] = (
    ("MX-110", "industrial"), ("MX-120", "industrial"), ("MX-210", "consumer"),
    ("MX-400", "tactical"),
)  # fmt: skip
YEAR_D = 365.25
DRIFT_BIAS = 2e-3, 8e-3  # rad/s and m/s² in a year, of gyro and accelerometer
DRIFT_SCALE = 1.5e-3  # in a year
OFF_SCALE = 8e-4  # by which the models' mean scale factors differ
NONE, SQUARE = np.zeros(3), np.zeros((3, 3))
IDEAL = UnitErrors(Kg=np.eye(3), Bg=NONE, G=SQUARE, Ka=np.eye(3), Ba=NONE, P=SQUARE)


@dataclass(frozen=True)
class LineUnit:
    """A unit with its true coefficients at the beginning, and what they change by in a year."""

    number: int
    model: int
    at_first: UnitErrors
    drift: UnitErrors

    @property
    def serial(self) -> str:
        return f"SN{self.number:04d}"

    @property
    def grade(self) -> Grade:
        return MODELS[self.model][1]

    def after(self, years: float, kept: float) -> UnitErrors:
        """Its coefficients. kept: the share of what it had that its last adjustment left."""
        off = combined(self.at_first, IDEAL, -1.0)
        return combined(combined(IDEAL, off, kept), self.drift, years)


@dataclass(frozen=True)
class Line:
    """What determines a store."""

    seed: int
    runs: int
    units: tuple[LineUnit, ...]


def draw_line(seed: int, runs: int, units: int) -> Line:
    """A line of a seed with so many runs of so many units."""
    rng = np.random.default_rng([seed, 61])
    return Line(seed, runs, tuple(_unit(rng, number) for number in range(units)))


def combined(one: UnitErrors, other: UnitErrors, factor: float) -> UnitErrors:
    """one + factor·other, coefficient by coefficient."""
    sums = {name: getattr(one, name) + factor * getattr(other, name) for name in vars(one)}
    return UnitErrors(**sums)


def station_name(number: int) -> str:
    return f"ST-{number + 1:02d}"


def _unit(rng: np.random.Generator, number: int) -> LineUnit:
    """Of its model's distribution: the plant's, about a mean scale factor of the model's own."""
    model = number % len(MODELS)
    mean = np.eye(3) * OFF_SCALE * (model - (len(MODELS) - 1) / 2.0)
    first = draw_unit(int(rng.integers(1, 2**31 - 1)))
    drift = UnitErrors(
        Kg=np.diag(DRIFT_SCALE * rng.standard_normal(3)),
        Bg=DRIFT_BIAS[0] * rng.standard_normal(3),
        G=SQUARE,
        Ka=np.diag(DRIFT_SCALE * rng.standard_normal(3)),
        Ba=DRIFT_BIAS[1] * rng.standard_normal(3),
        P=SQUARE,
    )
    first = replace(first, Kg=first.Kg + mean, Ka=first.Ka + mean)
    return LineUnit(number, model, first, drift)


# What a run of the line gives: by the plant and the real calibration, or of the same physics.

G = 9.80665  # m/s²
AXES = "xyz"
TRUTH_OF_CASE = 1  # of the unit that the plant plays, before it becomes one of the line
Values = dict[str, dict[str, float]]  # by item and element


def case_of(seed: int, grade: Grade) -> Case:
    """A run of the line as the plant plays it: thirty rests and turns of five seconds."""
    return Case(
        seed=seed, unit_seed=TRUTH_OF_CASE, grade=grade, rate_hz=20, rates_deg_s=(30.0, 120.0),
        dwell_s=5.0,
    )  # fmt: skip


def played(case: Case, truth: UnitErrors) -> Recording:
    """A case with a unit of these coefficients in the place of the plant's own."""
    simulated = simulate(case)
    rates, force = np.split(simulated.reported.T, 2)
    own = truth.reads(rates, force) - draw_unit(TRUTH_OF_CASE).reads(rates, force)
    steps = [noise.step for noise in channel_noise(case.grade)]
    recording, rng = simulated.recording, np.random.default_rng([case.seed, 63])
    columns = dict(recording.imu.columns)
    for channel, series, step in zip(GYRO + ACCEL, own, steps, strict=True):
        spread = step * (rng.uniform(size=len(series)) - 0.5)  # rounded twice as if once
        columns[channel] = np.round((columns[channel] + spread + series) / step) * step
    imu = replace(recording.imu, columns=columns)
    return replace(recording, imu=imu)


def templates(line: Line) -> Mapping[Grade, Calibration]:
    """The real calibration of one recording of each grade: its U and clauses hold for all."""
    grades = {unit.grade for unit in line.units}
    return {grade: _calibrated(case_of(line.seed, grade)) for grade in grades}


def _calibrated(case: Case) -> Calibration:
    recording = simulate(case).recording
    specification = specification_for(recording.manifest.standard, None)
    evaluation = evaluation_for(recording, "GUM", {})
    return calibrate(
        specification, recording, run="r0", code_version="1", evaluation=evaluation,
        own_latitude_deg=None,
    )  # fmt: skip


def true_values(unit: UnitErrors) -> Values:
    """The coefficients as the items of JJF 2003-2022, in their units; SI: models (1) and (2)."""
    pairs = [(i, j) for i in range(3) for j in range(3)]
    beside = [(i, j) for i, j in pairs if i != j]
    degrees = 180.0 / np.pi

    def diagonal(matrix: np.ndarray, factor: float = 1.0) -> dict[str, float]:
        return {AXES[i]: float(matrix[i, i] * factor) for i in range(3)}

    def vector(values: np.ndarray, factor: float = 1.0) -> dict[str, float]:
        return {AXES[i]: float(values[i] * factor) for i in range(3)}

    def of(matrix: np.ndarray, where: list[tuple[int, int]], factor: float) -> dict[str, float]:
        return {AXES[i] + AXES[j]: float(matrix[i, j] * factor) for i, j in where}

    return {
        "gyro_scale_factor": diagonal(unit.Kg),
        "gyro_cross_coupling": of(unit.Kg, beside, 1.0),
        "gyro_bias": vector(unit.Bg, degrees),
        "gyro_g_sensitivity": of(unit.G, pairs, degrees * G),
        "accel_scale_factor": diagonal(unit.Ka),
        "accel_cross_coupling": of(unit.Ka, beside, 1.0),
        "accel_bias": vector(unit.Ba),
        "accel_rate_sensitivity": of(unit.P, beside, -1.0),  # eq. (12): of the other sign
    }


def result_of(
    truth: UnitErrors, template: Calibration, rng: np.random.Generator, without: str | None
) -> Calibration:
    """A calibration as the template's with values of this unit: truth and noise of u.

    without: an item that the run does not determine.
    """
    items = {}
    for name, values in true_values(truth).items():
        item = template.items[name]
        value: dict[str, float | None] = {
            element: true + float(rng.standard_normal()) * (item.u[element] or 0.0)
            for element, true in values.items()
        }
        if name == without:
            value = dict.fromkeys(values)
        items[name] = item.model_copy(update={
            "value": value, "u": item.u if name != without else value,
            "U": item.U if name != without else value, "budgets": {}, "value_model": None,
            "value_without_earth_rotation": None, "u_without_earth_rotation": None,
            "U_without_earth_rotation": None,
        })  # fmt: skip
    return template.model_copy(update={
        "items": items, "information": {}, "segments": (), "remarks": (),
        "unavailable": {without: "no rest of the run is long enough"} if without else {},
        "unavailable_zh": {without: "测量中没有足够长的静止段"} if without else {},
    })  # fmt: skip


# A unit's visits to the line: run, run again where that did not end well, adjusted, certified.

INVALID, MISSING = 0.03, 0.01  # of the runs
AGAIN_H = 26.0  # until a unit is run again
RETESTS = 0.9  # of the runs that did not end well
ADJUSTED_TO = 0.3  # of its errors that an adjustment leaves
SHOCK = Remark(
    code="table_disturbed", en="The table was disturbed while the unit was at rest.",
    zh="静止测量期间转台受到扰动。", blocks_pass=True, run="invalid",
)  # fmt: skip


class LineRun(Frozen):
    """One run. visit: the unit's how manyeth; attempt: 0 for the first of the visit. is_last: no
    other follows in the visit. adjusted: whether the unit was adjusted since the attempt before.
    kept, years: how its coefficients stood, as `LineUnit.after` has it.
    """

    unit: int
    number: int
    at: datetime
    station: int
    visit: int
    attempt: int
    adjusted: bool
    is_last: bool
    kept: float
    years: float
    calibration: Calibration
    decision: Decision


@dataclass
class _State:
    """How a unit stands between two runs."""

    kept: float
    since: float  # years at which it was adjusted last


def runs_of(
    line: Line, unit: LineUnit, measured: Mapping[Grade, Calibration], tolerance: Tolerance
) -> Iterator[LineRun]:
    """A unit's runs from the oldest, as many as each unit of the line has."""
    rng = np.random.default_rng([line.seed, 62, unit.number])
    count = line.runs // len(line.units) + (unit.number < line.runs % len(line.units))
    pause = YEARS * YEAR_D * float(rng.uniform(0.86, 0.97)) / max(1, count)
    day, state, visit, made = float(rng.uniform(0.0, pause)), _State(1.0, 0.0), 0, 0
    while made < count:
        station = int(rng.integers(STATIONS))
        for one in _visit(unit, measured[unit.grade], tolerance, rng, state, day, station):
            is_last = one.is_last or made + 1 == count
            yield one.model_copy(update={"visit": visit, "number": made, "is_last": is_last})
            made += 1
            if made == count:
                break
        day, visit = day + pause * float(rng.uniform(0.6, 1.5)), visit + 1


def _visit(
    unit: LineUnit,
    template: Calibration,
    tolerance: Tolerance,
    rng: np.random.Generator,
    state: _State,
    day: float,
    station: int,
) -> Iterator[LineRun]:
    """Runs of one visit: at most three, the last of them after an adjustment."""
    adjusted = False
    for attempt in range(3):
        at = BEGINNING + timedelta(days=day, hours=AGAIN_H * attempt)
        kept, years = state.kept, (at - BEGINNING).days / YEAR_D - state.since
        truth = unit.after(years, kept)
        chance = rng.uniform()
        without = "gyro_g_sensitivity" if INVALID < chance < INVALID + MISSING else None
        result = result_of(truth, template, rng, without)
        if chance < INVALID:
            result = result.model_copy(update={"remarks": (SHOCK,)})
        decision = decide(result, tolerance)
        well = decision.verdict == "pass"
        is_last = well or attempt == 2 or rng.uniform() > RETESTS
        yield LineRun(
            unit=unit.number, number=0, at=at, station=station, visit=0, attempt=attempt,
            adjusted=adjusted, is_last=is_last, kept=kept, years=years,
            calibration=result, decision=decision,
        )  # fmt: skip
        if is_last:
            return
        adjusted = attempt == 1 and decision.verdict == "fail"
        if adjusted:
            state.kept, state.since = ADJUSTED_TO, (at - BEGINNING).days / YEAR_D


# The papers of the line: limits of each model, laboratory, turntables, certificates.

MAKER = "Plant"
INTERVALS = (3, 6, 12)  # months
CLIENTS = ("North Works", "Client & Co", "Harbour Instruments")
LIMITS = (
    ("gyro_scale_factor", "1", 0.016), ("gyro_cross_coupling", "1", 0.0068),
    ("gyro_bias", "deg/s", 0.65), ("gyro_g_sensitivity", "(deg/s)/g", 0.028),
    ("accel_scale_factor", "1", 0.016), ("accel_cross_coupling", "1", 0.0068),
    ("accel_bias", "m/s2", 0.12), ("accel_rate_sensitivity", "m", 0.0014),
)  # fmt: skip
ONE_SIDED = "MX-400"  # its scale factors have a lower limit alone
LABORATORY = Laboratory(
    party=Party(name="Line", name_zh="生产线", address="1 Road", address_zh="路 1 号"),
    certificate_prefix="LINE",
)


def tolerance_of(model: str) -> Tolerance:
    """Limits about three deviations of the production wide."""
    limits = []
    for item, unit, size in LIMITS:
        if item.endswith("scale_factor"):
            one_sided = model == ONE_SIDED
            bounds: dict[str, Any] = {"lower": -size} if one_sided else {"magnitude": size}
            bounds |= {"relative": True, "nominal": 1.0, "U_max": size / 4}
        else:
            bounds = {"magnitude": size}
        limits.append(Limit(item=item, unit=unit, **bounds))
    return Tolerance(
        manufacturer=MAKER, model=model, document=f"data sheet of {model}", limits=tuple(limits)
    )


def turntables() -> list[list[MeasurementStandard]]:
    """Each year's certificate of the turntable of each station, the oldest year first."""
    return [[_turntable(station, year) for station in range(STATIONS)] for year in range(4)]


def turntable_on(station: int, day: date) -> MeasurementStandard:
    """The turntable with the certificate that counts on a day."""
    every = [each[station] for each in turntables()]
    return max(
        (each for each in every if each.calibrated_on and each.calibrated_on <= day),
        key=lambda each: each.calibrated_on or date.min,
    )


def _turntable(station: int, year: int) -> MeasurementStandard:
    begins = (BEGINNING - timedelta(days=40 + 35 * station)).date()
    begins = begins.replace(year=begins.year + year)
    return MeasurementStandard(
        name="Three-axis turntable", name_zh="三轴转台", serial=f"TT-{station_name(station)}",
        accuracy="", certificate=f"TT-{station + 1}-{begins.year}", calibrated_on=begins,
        valid_until=begins + timedelta(days=400),
    )  # fmt: skip


def manifest_of_run(unit: LineUnit, run: LineRun) -> dict[str, Any]:
    """What the manifest says of who, where and when."""
    standard = turntable_on(run.station, run.at.date())
    return {
        "recording_id": f"{unit.serial}-{run.number:03d}",
        "acquired_at": run.at.isoformat(),
        "recorded_at": run.at.isoformat(),
        "procedure": "jjf2003_short",
        "equipment": [
            {"name": standard.name, "serial": standard.serial, "certificate": standard.certificate}
        ],
        "unit": {"manufacturer": MAKER, "model": MODELS[unit.model][0], "serial": unit.serial},
    }


def order_of(unit: LineUnit, run: LineRun) -> Order:
    """The client's order, which agrees on an interval."""
    client = CLIENTS[unit.number % len(CLIENTS)]
    party = Party(name=client, name_zh=client, address="2 Road", address_zh="路 2 号")
    months = INTERVALS[unit.number % len(INTERVALS)]
    return Order(client=party, received=run.at.date(), interval_months=months)


def certificate_of(unit: LineUnit, run: LineRun, manifest: Manifest, number: str) -> Certificate:
    """The certificate of a run: issued where it is the last of its visit, else a draft."""
    order, day, issued = order_of(unit, run), run.at.date(), run.is_last
    standard = turntable_on(run.station, day)
    moment = run.at + timedelta(hours=3)
    names = ("draft", "Wang Li"), ("check", "Zhao Min"), ("issue", "Chen Jie")
    steps = tuple(
        Step.model_validate({"step": step, "person": person, "at": moment})
        for step, person in names[: 3 if issued else 1]
    )
    return Certificate(
        number=number, state="issued" if issued else "draft", calibrated_on=day,
        issued_on=moment.date(), due=due_date(day, order, run.calibration),
        laboratory=LABORATORY.model_copy(update={"equipment": (standard,)}), order=order,
        manifest=manifest, calibration=run.calibration, decision=run.decision, steps=steps,
    )  # fmt: skip


def row_of(certificate: Certificate, run: LineRun, result: str, unit: int) -> dict[str, Any]:
    """A certificate's row of the register, with the name of its record."""
    record = f"certificates/{certificate.number}.json"
    words = certificate.purpose + (" as-left" if run.adjusted else "")
    content = certificate.model_dump_json().encode()
    return {
        "number": certificate.number, "result": result, "run": certificate.calibration.run,
        "unit": unit, "state": certificate.state, "verdict": certificate.decision.verdict,
        "purpose": words, "calibrated_on": certificate.calibrated_on,
        "issued_on": certificate.issued_on, "due": certificate.due,
        "kept_at": run.at + timedelta(hours=3), "pdf": "", "pdf_sha256": "", "record": record,
        "record_sha256": hashlib.sha256(content).hexdigest(),
        "limits": len(certificate.decision.limits),
    }  # fmt: skip


# Some runs of the line as recordings, taken in and calibrated as every run is.

PERIODS = 8  # of the years, each with a recording of each station
OF_A_UNIT = 2


@dataclass
class Recorded:
    """Which runs have a recording: one of each station in each period, two of a unit at most.

    most: how many there may be. found: how many there are of each station and period.
    """

    most: int
    found: Counter[tuple[int, int]] = field(default_factory=Counter)
    of_units: Counter[int] = field(default_factory=Counter)

    def takes(self, run: LineRun) -> bool:
        """Whether a run is to have one, which is counted then."""
        period = int(PERIODS * (run.at - BEGINNING).days / (YEARS * YEAR_D))
        cell = (run.station, period)
        is_full = self.found.total() >= self.most or self.of_units[run.unit] >= OF_A_UNIT
        if run.attempt or is_full or self.found[cell]:
            return False
        self.found[cell] += 1
        self.of_units[run.unit] += 1
        return True


def as_recorded(
    line: Line, unit: LineUnit, run: LineRun, tolerance: Tolerance, recorded: Recorded, home: Home
) -> LineRun:
    """The run as it is, or with the real result of a recording that was taken in."""
    if run.calibration.validity.verdict == "invalid" or not recorded.takes(run):
        return run
    taken, _ = runs.add(recording_of(line, unit, run), home)
    calibration = estimate(taken, home)
    decision = decide(calibration, tolerance)
    return run.model_copy(update={"calibration": calibration, "decision": decision})


def recording_of(line: Line, unit: LineUnit, run: LineRun) -> Recording:
    """The run as the plant plays it, with its unit's coefficients of that day."""
    case = case_of(line.seed * 100_000 + 100 * unit.number + run.number, unit.grade)
    recording = played(case, unit.after(run.years, run.kept))
    declared = recording.manifest.model_dump(mode="json", exclude_none=True)
    declared |= manifest_of_run(unit, run)
    declared["station"]["id"] = station_name(run.station)
    return Recording(
        Manifest.model_validate(declared), recording.imu, recording.table, recording.environment
    )


# The line as a store: rows in bulk, by the functions that make them of a single run.

Rows = dict[str, list[dict[str, Any]]]
FILLED = (
    "runs", "results", "elements", "outcomes", "equipment", "certificates", "decisions",
)  # fmt: skip
UNCERTIFIED = 0.03  # of the runs
SECONDS, ROWS = 235.0, 4_700


@dataclass
class _Numbers:
    """Serial numbers of certificates by year."""

    last: dict[int, int] = field(default_factory=dict)

    def next(self, year: int) -> str:
        self.last[year] = self.last.get(year, 0) + 1
        return f"LINE-{year}-{self.last[year]:05d}"


def fill(home: Home, line: Line, recorded: Recorded, progress: Callable[[int, int], None]) -> None:
    """Makes the store of a line in a home. recorded: how many runs have a recording."""
    home.tolerances.mkdir(parents=True)
    home.certificates.mkdir()
    for model, _ in MODELS:
        text = tolerance_of(model).model_dump_json(exclude_none=True)
        (home.tolerances / f"{model}.json").write_text(text, encoding="utf-8")
    first, *later = turntables()
    equipment.add(first, home, "Wang Li")
    for renewed in later:
        equipment.renew(renewed, home, "Wang Li")
    numbers, measured, done = _Numbers(), templates(line), 0
    for unit in line.units:
        tolerance = tolerance_of(MODELS[unit.model][0])
        made = []
        for run in runs_of(line, unit, measured, tolerance):
            made.append(as_recorded(line, unit, run, tolerance, recorded, home))
            done += 1
            progress(done, line.runs)
        _keep(home, unit, made, numbers)


def _keep(home: Home, unit: LineUnit, made: list[LineRun], numbers: _Numbers) -> None:
    """All of a unit in one transaction; what the recorded runs have already stays."""
    rows: Rows = {name: [] for name in FILLED}
    with database.changing(home) as connection:
        for run in made:
            manifest = manifest_for(unit, run)
            number = unit_id(connection, manifest.unit)
            _add(rows, home, unit, run, manifest, number, numbers)
        for name, some in rows.items():
            database.add_all_new(connection, tables.metadata.tables[name], some)
        for row in rows["runs"]:  # those that were imported today were imported long ago
            then = sql.update(tables.runs).where(tables.runs.c.id == row["id"])
            connection.execute(then.values(imported_at=row["imported_at"]))


def manifest_for(unit: LineUnit, run: LineRun) -> Manifest:
    """The manifest of a run of which there is no recording."""
    return Manifest.model_validate({
        "format": "mimu-recording/1", "standard": "JJF 2003-2022",
        "station": {"id": station_name(run.station), "latitude_deg": 39.9, "gravity_m_s2": 9.8015},
        **manifest_of_run(unit, run),
    })  # fmt: skip


def _add(
    rows: Rows, home: Home, unit: LineUnit, run: LineRun, manifest: Manifest, key: int,
    numbers: _Numbers,
) -> None:  # fmt: skip
    calibration = named(run, manifest)
    run = run.model_copy(update={"calibration": calibration})
    document, taken_in = calibration.model_dump_json(), run.at + timedelta(hours=1)
    result = result_id(None, document)
    rows["runs"].append({
        "id": calibration.run, "digest": calibration.digest,
        "recording_id": calibration.recording_id, "unit": key, "standard": manifest.standard,
        "imported_at": taken_in, "seconds": SECONDS, "rows": ROWS, **runs.provenance(manifest),
    })  # fmt: skip
    rows["results"].append({
        "id": result, "run": calibration.run, "method": calibration.method,
        "code_version": calibration.code_version, "made_at": taken_in, "document": document,
    })  # fmt: skip
    rows["elements"] += [{"result": result} | row for row in results.elements_of(calibration)]
    outcome = results.outcome_of(calibration)
    rows["outcomes"].append({"result": result, "made_at": taken_in} | outcome)
    rows["equipment"] += [
        {"run": calibration.run, "document": runs.STANDARD_DOCUMENT, **used.model_dump()}
        for used in runs.equipment_of(manifest)
    ]
    _keep_manifest(home, calibration.digest, manifest)
    is_invalid = calibration.validity.verdict == "invalid"
    if not is_invalid and (run.number * 0.618 + unit.number * 0.414) % 1.0 > UNCERTIFIED:
        issued = numbers.next(run.at.year) if run.is_last else f"draft-{calibration.run[:8]}"
        certificate = certificate_of(unit, run, manifest, issued)
        rows["certificates"].append(row_of(certificate, run, result, key))
        rows["decisions"] += [
            {"certificate": issued} | row for row in results.decisions_of(run.decision)
        ]
        text = certificate.model_dump_json()
        (home.certificates / f"{issued}.json").write_text(text, encoding="utf-8")


def named(run: LineRun, manifest: Manifest) -> Calibration:
    """The calibration with the names of its run; that of a recorded run has them."""
    if run.calibration.recording_id == manifest.recording_id:
        return run.calibration
    digest = sha256(f"{manifest.recording_id} at {manifest.station.id}".encode()).hexdigest()
    names = {"run": f"r{digest[:12]}", "digest": digest, "recording_id": manifest.recording_id}
    return run.calibration.model_copy(update=names)


def _keep_manifest(home: Home, digest: str, manifest: Manifest) -> None:
    folder = home.columns / digest
    if not folder.exists():
        folder.mkdir(parents=True)
        text = manifest.model_dump_json(exclude_none=True)
        (folder / MANIFEST).write_text(text, encoding="utf-8")


def recorded_runs(home: Home) -> Iterator[str]:
    """The ids of runs of which there is a recording, in the order of time."""
    kept = {path.stem for path in home.raw.glob("*.mcap")}
    asked = sql.select(tables.runs.c.id, tables.runs.c.digest).order_by(tables.runs.c.recorded_on)
    yield from (row.id for row in database.rows(home, asked) if row.digest in kept)
