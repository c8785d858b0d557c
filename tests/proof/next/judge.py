"""One case: what `explain` leaves open, what `next` proposes, and what the proposal then shows."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from schemas.base import Frozen, Unusable
from schemas.next_recording import NextRecording
from schemas.orders import NextOrder
from schemas.procedure import Procedure
from schemas.recording import Recording
from schemas.station import StationFile
from storage import settings
from storage.catalogue import runs
from storage.home import Home
from tasks.experiment.abilities import Abilities
from tasks.experiment.open_question import open_question
from tasks.experiment.separation import left_by_real_fit
from tasks.explain.explain import explain
from tasks.explain.search.special_case import HOLDS
from tasks.stages.next_recording import next_recording
from tests.proof.next.draw import draw, has_chamber
from tests.proof.plant.case import Case
from tests.proof.plant.simulate import simulate
from tests.proof.plant.world import STATED_K_S
from tests.tasks.station.sample_stations import sample

MINUTES = 15.0
SEED_AFTER = 1_000_003  # added to the case's: the proposed run has noise of its own


class Answer(Frozen):
    """A case that was played to its end.

    effect: the truth. chamber: whether the station can set its chamber. opened: the effects that
    are open after the first recording, none where `explain` names everything by itself. predicted,
    repeated: chi-squared expected of the proposal, and of the first recording once more; minutes,
    base_minutes: that they take. found: the names of each finding of the proposed recording, with
    those that it cannot tell from it. achieved: chi-squared by which it tells the truth from the
    nearest other; None without a recording or where the truth is not among them. refusal: why
    `next` proposes nothing.
    """

    number: int
    effect: str
    chamber: bool = False
    opened: tuple[str, ...] = ()
    predicted: float | None = None
    probability: float | None = None
    minutes: float | None = None
    base_minutes: float | None = None
    repeated: float | None = None
    found: tuple[tuple[str, ...], ...] = ()
    achieved: float | None = None
    refusal: str | None = None

    @property
    def is_proposed(self) -> bool:
        return self.minutes is not None

    @property
    def per_minute(self) -> float | None:
        """Chi-squared per minute of the proposal, in that of the first recording once more."""
        if not (self.minutes and self.base_minutes and self.repeated and self.predicted):
            return None
        return (self.predicted / self.minutes) / (self.repeated / self.base_minutes)

    @property
    def is_right(self) -> bool:
        """Whether the truth is named, alone and with no other name beside it."""
        return self.found == ((self.effect,),)

    @property
    def is_wrong(self) -> bool:
        """Whether a name is said that the recording does not have."""
        return any(self.effect not in names for names in self.found)


def played(seed: int, number: int) -> Answer:
    """The case of a seed, from its first recording to the explanation of the proposed one."""
    case, effect = draw(seed, number)
    recording = simulate(case).recording
    try:
        question = open_question(recording)
    except Unusable as error:
        return Answer(number=number, effect=effect, refusal=str(error))
    if question is None:
        return Answer(number=number, effect=effect)
    chamber = has_chamber(seed, number)
    with TemporaryDirectory() as folder:
        station = _station_with_chamber(recording, Path(folder)) if chamber else None
        answer = _decided(number, effect, case, recording, Path(folder), station)
    return answer.model_copy(update={"chamber": chamber})


def _station_with_chamber(recording: Recording, folder: Path) -> str:
    """A station file: the recording's own table, and a chamber that can be set."""
    able, file = Abilities.of_recording(recording), sample()
    axes = {
        axis.name: {
            "rate_deg_s": rate, "acceleration_deg_s2": able.acceleration_deg_s2,
            "angle_deg": None if endless else (-360.0, 360.0),
        }
        for axis, rate, endless in zip(
            able.station.table_axes or (), able.rates_deg_s, able.endless, strict=True
        )
    }  # fmt: skip
    file["limits"]["axes"] = axes
    file["limits"]["chamber"]["rate_k_min"] = 60.0 * STATED_K_S
    file |= {"station": able.station, "mount": able.mount, "unit": recording.manifest.unit}
    path = folder / "station.json"
    path.write_text(StationFile.model_validate(file).model_dump_json(), encoding="utf-8")
    return str(path)


def _decided(
    number: int, effect: str, case: Case, recording: Recording, folder: Path, station: str | None
) -> Answer:
    home, out = Home(folder / "home"), folder / "next.json"
    run, _ = runs.add(recording, home)
    order = NextOrder(runs=(run.id,), minutes=MINUTES, out=str(out), station=station)
    try:
        answer = next_recording([run], home, order)
    except Unusable as error:
        return Answer(number=number, effect=effect, refusal=str(error))
    response = Answer(
        number=number, effect=effect, opened=answer.decides,
        predicted=answer.predicted.delta_chi2, probability=answer.predicted.probability_right,
        minutes=answer.minutes, base_minutes=answer.repeat_of_base.minutes,
        repeated=answer.repeat_of_base.delta_chi2,
    )  # fmt: skip
    if answer.procedure is None:
        return response.model_copy(update={"refusal": answer.statement.en})
    return response.model_copy(update=_after(effect, case, answer, settings.read(out, Procedure)))


def _after(
    effect: str, case: Case, answer: NextRecording, procedure: Procedure
) -> dict[str, object]:
    """What the unit shows when the proposal is carried out."""
    proposed = case.model_copy(
        update={
            "seed": case.seed + SEED_AFTER,
            "unit_seed": case.seed,
            "procedure": "given",
            "given": procedure.model_dump(mode="json"),
        }
    )
    recording = simulate(proposed).recording
    findings = explain(recording).findings
    found = tuple(
        tuple(sorted({one.effect, *one.group, *one.indistinguishable}))
        for one in findings
        if one.effect != "unnamed"
    )
    return {"found": found, "achieved": _achieved(effect, recording, answer.decides)}


def _achieved(effect: str, recording: Recording, names: Sequence[str]) -> float | None:
    """Chi-squared by which the nearest other fits worse than the truth; None without the truth.

    An effect of which the truth is a special case fits as well: of it counts what the recording
    would have shown of a typical departure.
    """
    if effect not in names:
        return None
    try:
        # The truth first: the noise is taken from what the first one leaves.
        question = open_question(recording, sorted(names, key=lambda name: name != effect))
    except Unusable:
        return None
    if question is None:
        return None
    blocks, noises = question.fit.blocks, question.fit.noises
    left = {
        name: left_by_real_fit(model, blocks, noises) for name, model in question.models.items()
    }
    general = HOLDS.get(effect)
    shown = [left[name] - left[effect] for name in left if name not in (effect, general)]
    if general is not None and general in question.models:
        readings = np.nan_to_num(question.models[general].prediction(blocks.motion))
        departed = replace(blocks, readings=readings)
        shown.append(left_by_real_fit(question.models[effect], departed, noises))
    return min(shown)
