"""Stage: the shortest recording that would settle what `explain` left open."""

import os
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

from schemas.base import Unusable
from schemas.discrepancy import NextRecording, PredictedEvidence, RepeatOfBase
from schemas.orders import NextOrder
from schemas.recording import Recording
from schemas.station import StationFile
from storage import settings
from storage.catalogue import runs
from storage.catalogue.runs import Run
from storage.home import Home
from storage.whole_files import written_out
from tasks.experiment.blocks import Abilities
from tasks.experiment.choose import NOTHING, Experiment, open_question, rivals_of
from tasks.experiment.separation import UnitNoise
from tasks.experiment.track import ThermalResponse
from tasks.explain.progress import Progress, report_progress, silent
from tasks.model.term import effect_name, separating_recording
from tasks.stages.acquire import procedure_named
from tasks.stages.stage import stage
from tasks.words import Message, clauses, identifiers, message, statement

if TYPE_CHECKING:
    from tasks.experiment.choose import Choice, OpenQuestion


REHEARSALS = 2  # trials of a procedure: each may reveal another effect that fits
NOISE_CHI2 = 1.0  # chi-squared that noise alone produces
LONGER_BY = 1.1  # above proportional time: the first blocks are the most informative
NO_NAME = {"unnamed"}  # placeholder where no effect of the catalogue is named
USUAL_MIN = 15.0  # where fewer are allowed, what these would give is tried too
LONGEST_MIN = 120.0  # that a longer recording is worth proposing


@stage("next")
def next_recording(
    of: Sequence[Run], home: Home, order: NextOrder, progress: Progress = silent
) -> NextRecording:
    """The shortest procedure that separates what a run's explanation could not.

    of: runs of one unit; the first one with an open question is used. Writes the procedure. Raises
    Unusable for runs of several units, names that are no effects, if nothing is open, or if the
    station's table is unknown; for a procedure file that is already there before the long work.
    """
    _refuse_several_units(of)
    _refuse_unknown(order.effects)
    if order.out or order.effects:
        _refuse_taken(_file(order, order.effects))
    station = settings.read(Path(order.station), StationFile) if order.station else None
    base = procedure_named(order.base) if order.base else None
    question = None
    for run in of:
        recording = runs.load(run, home)
        question = open_question(recording, order.effects, progress)
        if question is not None:
            break
    if question is None:
        raise Unusable(
            f"explain names every effect of {', '.join(run.recording_id for run in of)} by itself, "
            "so nothing is open: name with --for EFFECT,EFFECT what is to be told apart."
        )
    _refuse_taken(_file(order, question.names))
    report_progress(progress, "search")
    abilities = _abilities(recording, station)
    like = recording.manifest
    if station is not None:
        like = like.model_copy(update={"station": station.station, "mount": station.mount})
    experiment = Experiment(
        question.models, UnitNoise.of(recording, question.fit), abilities, like,
        f"decide_{'_'.join(question.names)}", base,
        thermal=ThermalResponse.of(recording, abilities.chamber) if abilities.chamber else None,
    )  # fmt: skip
    return _answer(experiment, question, recording, order)


def _refuse_several_units(of: Sequence[Run]) -> None:
    units = sorted({f"{run.manufacturer} {run.model} {run.serial}" for run in of})
    if len(units) > 1:
        raise Unusable(
            f"{', '.join(run.recording_id for run in of)} are recordings of different units "
            f"({', '.join(units)}): name those of one unit."
        )


def _refuse_unknown(effects: Sequence[str]) -> None:
    prefix = "effect-"
    known = {each.removeprefix(prefix).replace("-", "_") for each in identifiers(prefix)} - NO_NAME
    for name in effects:
        if name not in known:
            near = get_close_matches(name.lower().replace(" ", "_"), sorted(known)) or sorted(known)
            raise Unusable(
                f"--for {name}: the catalogue has no such effect; meant may be {', '.join(near)}."
            )
    if len(set(effects)) < len(effects):
        raise Unusable(f"--for {','.join(effects)} names an effect twice; name each once.")


def _abilities(recording: Recording, station: StationFile | None) -> Abilities:
    if station is None:
        return Abilities.of_recording(recording)
    return Abilities.of_station(station).driven_as(recording)


def _answer(
    experiment: Experiment, question: "OpenQuestion", recording: Recording, order: NextOrder
) -> NextRecording:
    choice = _apart_from_rivals(experiment, question, order.minutes)
    longer = None
    if not choice.is_enough and order.minutes < USUAL_MIN:
        longer = _apart_from_rivals(experiment, question, USUAL_MIN)
    typical = replace(experiment, models=question.typical)
    repeated = typical.left_by(question.fit.blocks, question.fit.noises)
    minutes = float(recording.imu.t[-1] - recording.imu.t[0]) / 60.0
    path = _written(choice, order, question) if choice.is_enough else None
    return NextRecording(
        decides=question.names,
        procedure=None if path is None else str(path),
        minutes=choice.minutes if path is not None else None,
        steps=tuple(step.model_dump(mode="json") for step in choice.procedure.steps)
        if path is not None
        else (),
        predicted=PredictedEvidence(
            delta_chi2=choice.expected, probability_right=choice.probability
        ),
        repeat_of_base=RepeatOfBase(minutes=minutes, delta_chi2=repeated),
        statement=statement(_sentence(question, choice, longer, repeated, minutes, order)),
    )


def _apart_from_rivals(
    experiment: Experiment, question: "OpenQuestion", minutes: float
) -> "Choice":
    """The shortest; for one suspected effect again, where others would fit that recording too. What
    is expected of it is of an effect as large as it typically is.
    """
    experiment = _without_warm_up_effect(experiment, question)
    choice = experiment.shortest(minutes)
    for _ in range(REHEARSALS if len(question.names) == 1 else 0):
        found = rivals_of(choice, experiment, question.names[0], question.others)
        new = {name: model for name, model in found.items() if name not in experiment.rivals}
        if not choice.is_enough or not new:
            break
        experiment = replace(experiment, rivals={**experiment.rivals, **new})
        choice = experiment.shortest(minutes)
    if not choice.is_enough or len(question.names) > 1:
        return choice
    typical = replace(experiment, models=question.typical).judged(choice.procedure)
    return replace(choice, expected=typical.expected)


def _without_warm_up_effect(experiment: Experiment, question: "OpenQuestion") -> Experiment:
    """Where the chamber changes all effects but warm-up, the rival of warm-up is no effect."""
    name = _warm_up_effect(question)
    if name is None or experiment.thermal is None:
        return experiment
    model = question.models[name]
    nothing = model.without({key for key in model.places if key[0] == name})
    return replace(experiment, by_silence=name, rivals={NOTHING: nothing})


def _warm_up_effect(question: "OpenQuestion") -> str | None:
    """The effect that depends on the time since power-on alone, not on the chamber."""
    if len(question.names) == 1:
        return None
    terms = [term for model in question.models.values() for term in model.terms]
    names = (term.name for term in terms if term.since_power_on)
    return next((name for name in names if name in question.names), None)


def _file(order: NextOrder, names: Sequence[str]) -> Path:
    return Path(order.out or f"next-{'-'.join(names)}.json").absolute()


def _refuse_taken(path: Path) -> None:
    if os.path.lexists(path):
        raise Unusable(f"{path} is already there; name a new file with --out.")
    if not path.parent.is_dir():
        raise Unusable(f"{path} cannot be written: there is no folder {path.parent}; make it.")


def _written(choice: "Choice", order: NextOrder, question: "OpenQuestion") -> Path:
    path = _file(order, question.names)
    _refuse_taken(path)
    with written_out(path) as draft:
        draft.write_text(choice.procedure.model_dump_json(indent=1) + "\n", encoding="utf-8")
    return path


def _sentence(
    question: "OpenQuestion",
    choice: "Choice",
    longer: "Choice | None",
    repeated: float,
    minutes: float,
    order: NextOrder,
) -> Message:
    effects = clauses([effect_name(name) for name in question.names], by="report-or")
    left = choice.expected if choice.is_enough else choice.left
    figures: dict[str, str | int] = {
        "count": len(question.names),
        "minutes": f"{choice.minutes:.1f}", "left": f"{left:.0f}",
        "percent": f"{100.0 * choice.probability:.0f}", "repeated": f"{repeated:.1f}",
        "base": f"{minutes:.1f}", "longest": f"{order.minutes:g}", "needed": f"{choice.needed:.0f}",
    }  # fmt: skip
    silent = _warm_up_effect(question)
    if choice.is_enough and silent is not None:
        name = effect_name(silent)
        return message("next-decides-by-silence", effects=effects, silent=name, **figures)
    if choice.is_enough:
        return message("next-decides", effects=effects, **figures)
    why = _why(choice, longer, order.minutes, len(question.names))
    known = [one for one in map(separating_recording, question.names) if one is not None]
    if not known:
        return message("next-impossible", effects=effects, why=why, **figures)
    other = clauses(known, by="next-or")
    return message("next-undecided", effects=effects, why=why, other=other, **figures)


def _why(choice: "Choice", longer: "Choice | None", most_minutes: float, count: int) -> Message:
    """Whether more would do than was allowed: a longer one that was tried, else more of the same,
    for evidence adds up with time.
    """
    if longer is not None and longer.is_enough:
        needs, minutes = f"{longer.minutes:.1f}", ceil(longer.minutes)
        return message("next-found-longer", needs=needs, minutes=minutes)
    if longer is not None:  # one block may show nothing where others do
        choice, most_minutes = longer, USUAL_MIN
    if choice.left < NOISE_CHI2:
        return message("next-nothing-moves", count=count)
    in_proportion = LONGER_BY * max(choice.minutes, most_minutes) / choice.share
    if in_proportion > LONGEST_MIN:
        return message("next-too-little", count=count, hours=f"{in_proportion / 60.0:.0f}")
    return message("next-longer", minutes=f"{ceil(in_proportion / 5.0) * 5:d}")
