"""Stage: estimates every item that a run allows, and stores the result."""

import json
import os
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cached_property, partial
from pathlib import Path
from typing import Any, get_args

from pydantic import ValidationError

from schemas.base import Unusable
from schemas.calibration import (
    OF_NO_STANDARD,
    OF_STANDARD,
    Calibration,
    EvidenceFile,
    UncertaintyKind,
)
from schemas.certificate import Laboratory
from schemas.laboratory import EquipmentLimit, LimitName, MeasurementStandard, ResultAxes
from schemas.orders import Estimation, ExportOrder, UncertaintyName
from schemas.recording import Manifest, Recording
from schemas.text import Validity, texts_fields
from schemas.tolerance import Decision
from storage import settings
from storage.catalogue import equipment, results, runs
from storage.catalogue.runs import Run, provenance
from storage.home import Home
from tasks.calibrate.calibrate import Evaluation, calibrate, evaluation_for
from tasks.calibrate.evidence_file import evidence_file
from tasks.calibrate.reference import as_certified
from tasks.model.catalogue import catalogue
from tasks.motion.encoders import gives_angles
from tasks.readings.codes import codes_put_right
from tasks.specifications.estimate import Specification
from tasks.specifications.register import SPECIFICATIONS, specification_for
from tasks.stages.stage import stage
from tasks.uncertainty.equipment import own_limits
from tasks.version import code_version
from tasks.words import say, statement

# The measurement standards used for a run, and what they state of its reference.

# on which two documents may disagree
PAPER = ("certificate", "traceable", "calibrated_on", "valid_until")


def standards_in_use(
    manifest: Manifest, home: Home, laboratory: Laboratory | None, day: date | None
) -> tuple[MeasurementStandard, ...]:
    """The standards that a run names, else those that its laboratory lists.

    Those of the register with the certificate that counts on a day. What a run says is virtual
    stays so, whatever the register leaves out.
    """
    listed = of_manifest(manifest) or (laboratory.equipment if laboratory else ())
    registered = equipment.on_day(home, day) if listed else {}
    return tuple(
        registered.get(each.serial, each).model_copy(update={"virtual": True})
        if each.virtual
        else registered.get(each.serial, each)
        for each in listed
    )


def contradictions(
    manifest: Manifest, listed: Iterable[MeasurementStandard], home: Home, day: date | None
) -> tuple[str, ...]:
    """Contradictions between a run and laboratory.toml, or the register, on the standards it was
    measured with. None for a run that names no standard. A certificate that the register has
    renewed since the run is no contradiction.
    """
    used = {standard.serial: standard for standard in of_manifest(manifest)}
    if not used:
        return ()
    registered = equipment.on_day(home, day)
    found: list[str] = []
    for standard in listed:
        if own := used.get(standard.serial):
            found += _disputed(own, standard, "laboratory.toml", registered)
        else:
            found.append(
                f"laboratory.toml lists {standard.name} ({standard.serial}) as a measurement "
                f"standard, but the recording says that {', '.join(used)} were used"
            )
    for serial, own in used.items():
        if serial in registered:
            found += _disputed(own, registered[serial], "the register", registered)
    return tuple(dict.fromkeys(found))


def _disputed(
    own: MeasurementStandard, other: MeasurementStandard, paper: str, registered: Container[str]
) -> Iterator[str]:
    """The fields in which two records of one standard disagree on one certificate of it."""
    if own.certificate != other.certificate and own.serial in registered:
        return
    pairs: list[tuple[str, Any, Any]] = [
        (name, getattr(own, name), getattr(other, name)) for name in PAPER
    ]
    pairs += [
        (f"limits.{name}", own.limits[name].half_width, other.limits[name].half_width)
        for name in own.limits.keys() & other.limits.keys()
    ]
    for name, recorded, stated in pairs:
        if None not in (recorded, stated) and recorded != stated:
            yield (
                f"{own.name} ({own.serial}): the recording says {name} = {_written(recorded)}, "
                f"but {paper} says {_written(stated)}"
            )


def _written(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value}"


@dataclass(frozen=True)
class InUse:
    """The circumstances of a run: with what it was measured, and what its laboratory states of it.

    recording: as it was recorded. day: on which the standards were used; None where it is unknown.
    """

    recording: Recording
    laboratory: Laboratory | None
    standards: tuple[MeasurementStandard, ...]
    day: date | None

    @cached_property
    def limits(self) -> dict[LimitName, EquipmentLimit]:
        """The error limits of the equipment. Those in laboratory.toml take precedence over the
        certificates of the standards. Raises Unusable for a drift since an unknown day.
        """
        return own_limits(
            self.standards, self.laboratory.limits if self.laboratory else {}, self.day
        )

    @cached_property
    def certified(self) -> Recording:
        """The recording with its reference corrected by the certificates of the standards.

        Raises Unusable for a run outside of what they state, see `as_certified`.
        """
        own = self.laboratory.limits if self.laboratory else ()
        return as_certified(self.recording, self.standards, own)

    def evaluation(
        self, kind: UncertaintyKind = "GUM", axes: ResultAxes | None = None
    ) -> Evaluation:
        """How uncertainties are evaluated for it; see `evaluation_for`."""
        return evaluation_for(self.certified, kind, self.limits, axes)

    def calibrated(
        self, recording: Recording, by: Specification, evaluation: Evaluation, run: str, code: str
    ) -> Calibration:
        """The calibration of its recording, or of that with readings put right.

        code: the version.
        """
        latitude = self.laboratory.latitude_deg if self.laboratory else None
        return calibrate(
            by, recording, run=run, code_version=code, evaluation=evaluation,
            own_latitude_deg=latitude,
        )  # fmt: skip


def in_use(recording: Recording, home: Home, laboratory: Laboratory | None = None) -> InUse:
    """The circumstances of a run, by its manifest, the register and the laboratory.

    laboratory: that of the home, unless given.
    """
    laboratory = laboratory or settings.laboratory(home)
    day: date | None = provenance(recording.manifest)["recorded_on"]
    standards = standards_in_use(recording.manifest, home, laboratory, day)
    return InUse(recording, laboratory, standards, day)


def of_manifest(manifest: Manifest) -> tuple[MeasurementStandard, ...]:
    """The standards named in a manifest; `certify` refuses malformed records."""
    named = (manifest.model_extra or {}).get("equipment")
    records = named if isinstance(named, list | tuple) else ()
    return tuple(standard for each in records if (standard := _standard(each)))


def _standard(record: Any) -> MeasurementStandard | None:
    try:
        return MeasurementStandard.model_validate_json(json.dumps(record))
    except ValidationError:
        return None


UNCERTAINTIES: dict[UncertaintyName, UncertaintyKind] = {
    "gum": "GUM",
    "montecarlo": "Monte Carlo",
    "example": "as the specification's example",
}


@stage("estimate")
def estimate(
    run: Run, home: Home, how: Estimation | None = None, laboratory: Laboratory | None = None
) -> Calibration:
    """Calibrate a run and store the result; the same result twice is stored once.

    laboratory: that of the home, unless given. Its limits, and those of the standards in use, take
    precedence over Table 1 of the specification, errors that the standards state are taken off the
    reference, and its latitude is checked. With terms, the
    readings are corrected for their contributions first; that result stands beside the one without
    them and supersedes only one with the same terms. Raises Unusable for a term that this recording
    cannot have or does not determine.
    """
    calibration = calibration_of(run, home, how or Estimation(), laboratory)
    results.save(calibration, home)
    return calibration


def calibration_of(
    run: Run, home: Home, how: Estimation, laboratory: Laboratory | None
) -> Calibration:
    """The calibration of a run, which is not kept; see `estimate`."""
    used = in_use(runs.load(run, home), home, laboratory)
    recording = used.certified
    calibrated = partial(
        used.calibrated,
        by=specification_for(recording.manifest.standard, how.method),
        evaluation=used.evaluation(UNCERTAINTIES[how.uncertainty], how.axes),
        run=run.id,
        code=code_version(),
    )
    if how.terms is None:
        return calibrated(recording)
    return _with_terms(codes_put_right(recording), how.terms, calibrated)


def how_made(calibration: Calibration) -> Estimation:
    """How a result was estimated: its method, its way to the uncertainties, its terms, its axes."""
    kind = calibration.settings.get("uncertainty")
    stated = calibration.settings.get("axes")
    names = [name for name, each in UNCERTAINTIES.items() if each == kind]
    return Estimation(
        method=calibration.method,
        uncertainty=names[0] if names else "gum",
        terms=tuple(term.name for term in calibration.terms) or None,
        axes=next((axes for axes in get_args(ResultAxes) if axes == stated), None),
    )


def _with_terms(
    recording: Recording, names: Sequence[str], calibrate: Callable[[Recording], Calibration]
) -> Calibration:
    """The calibration of a recording whose readings were corrected for the named terms."""
    # Late: a calibration without terms needs none of it.
    from tasks.explain.correction.adopt import adopt
    from tasks.explain.explain import explain
    from tasks.explain.inputs.blocks import full_rate
    from tasks.explain.report.statements import refused

    recording_id = recording.manifest.recording_id
    if gives_angles(recording):
        raise Unusable(
            f"--terms {', '.join(names)}: {recording_id} has angle_* and no gyro_*, and terms are "
            "taken off rates alone; calibrate it without --terms"
        )
    known = {term.name for term in catalogue(recording, full_rate(recording).motion)}
    unknown = [name for name in names if name not in known]
    if unknown or not names:
        raise Unusable(
            f"--terms {', '.join(unknown) or repr('')}: {recording_id} can have "
            f"{', '.join(sorted(known))}; name some of these with commas between"
        )
    # What explain found is taken off as it found it; else what is asked for is fitted.
    explanation = explain(recording)
    findings = explanation.by_name
    if not findings.keys() >= set(names):
        explanation = explain(recording, only=names)
        findings = explanation.by_name
    for name in names:
        if name not in findings:
            raise Unusable(f"--terms {name}: {recording_id} does not determine it; leave it out")
        if refusal := findings[name].refusal:
            why = say(refused(refusal, setting=False))
            raise Unusable(f"--terms {name}: {recording_id}: {why} Leave it out")
    found = [findings[name] for name in names]  # two names may be one finding
    taken = [one for k, one in enumerate(found) if all(one is not each for each in found[:k])]
    return adopt(recording, taken, calibrate, explanation.determined)


# The calibration that an order refers to.


def read_calibration(reference: str, home: Home) -> Calibration:
    """A result by its id or its run's in the store, or from a mimu-calibration/1 file.

    Raises Unusable for none of these.
    """
    # returns False for text that cannot be a path, where Path.is_file raises
    if os.path.isfile(reference):
        return settings.read(Path(reference), Calibration)
    return results.find(reference, home).calibration


def correcting_calibration(reference: str, home: Home) -> Calibration:
    """The same, to correct readings with; Unusable for that of an invalid run, too."""
    calibration = read_calibration(reference, home)
    validity = calibration.validity
    if validity.verdict == "invalid":
        raise Unusable(
            f"run {calibration.run} is invalid: {validity.reasons[0].rstrip('.')}; nothing is "
            "corrected by it: measure again."
        )
    return calibration


# Whether a run can be relied on, before anything is said of its unit.


def validity_of(run: Run, home: Home) -> Validity:
    """The verdict on a run by the method of its specification; that of its result, if it has one
    of the readings as recorded.

    A run that the method cannot serve at all is valid with that remark: it was not judged.
    """
    method = OF_STANDARD.get(run.standard, OF_NO_STANDARD)
    for kept in reversed(results.of_run(run, home)):
        made = kept.calibration
        if (made.method, made.code_version) == (method, code_version()) and not made.terms:
            return made.validity
    # Late: a run with a result needs none of it.
    recording, laboratory = runs.load(run, home), settings.laboratory(home)
    try:
        used = in_use(recording, home, laboratory)
        by, evaluation = SPECIFICATIONS[method], used.evaluation()
        return used.calibrated(used.certified, by, evaluation, run.id, "").validity
    except Unusable as fault:
        return Validity(verdict="remarks", **texts_fields("reasons", (statement(str(fault)),)))


# The evidence file of a result, made again from its recording.


def evidence_of(
    calibration: Calibration, used: InUse, decision: Decision | None = None
) -> EvidenceFile:
    """What a result of a recording rests on; Unusable where it has no evidence file.

    calibration: as it is stated. used: with what it was made. decision: what was decided on it.
    """
    specification = specification_for(used.recording.manifest.standard, calibration.method)
    evaluation = used.evaluation(axes=how_made(calibration).axes)
    return evidence_file(calibration, specification, used.certified, evaluation, decision)


def as_text(evidence: EvidenceFile) -> str:
    """The text of the file."""
    return evidence.model_dump_json() + "\n"


def export_evidence(order: ExportOrder, home: Home) -> str:
    """The evidence file of a result, without a decision; Unusable where it has none, or where its
    recording is not in the store.
    """
    calibration = read_calibration(order.calibration, home)
    for run in runs.all_runs(home):
        if run.digest == calibration.digest:
            return as_text(evidence_of(calibration, in_use(runs.load(run, home), home)))
    raise Unusable(
        f"run {calibration.run} of {calibration.recording_id} is not in {home.path}, and its "
        "evidence is made of the recording: import that."
    )
