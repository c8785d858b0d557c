"""The shortest procedure is enough for what it promises, and an impossible one is none."""

from dataclasses import replace
from functools import cache

import pytest

from schemas.recording import Recording
from tasks.experiment.blocks import Abilities, blocks_of, steps_of
from tasks.experiment.choose import NOTHING, Choice, Experiment, open_question
from tasks.experiment.separation import UnitNoise, enough, probability_right
from tests.proof.plant.case import Case
from tests.proof.plant.simulate import simulate


@cache
def recorded() -> Recording:
    made = simulate(Case(seed=3, rate_hz=50, rates_deg_s=(20.0, 80.0, 200.0), dwell_s=5.0))
    return made.recording


@cache
def experiment(*effects: str) -> Experiment:
    recording = recorded()
    question = open_question(recording, effects)
    assert question is not None
    abilities = Abilities.of_recording(recording)
    return Experiment(
        question.models, UnitNoise.of(recording, question.fit), abilities, recording.manifest, "d"
    )


def test_what_is_promised_grows_with_the_difference_and_is_right_where_it_is_enough():
    chances = [probability_right(left, 30.0) for left in (0.0, 10.0, 30.0, enough(30.0), 200.0)]
    assert chances == sorted(chances)
    assert chances[0] == 0.0
    assert chances[3] == pytest.approx(0.95, abs=0.005)


def test_ramps_are_planned_as_the_table_makes_them():
    """Of the plant's, whose acceleration comes and goes as sin², ∫α²dt is ¾ of the limit's."""
    able = Abilities.of_recording(recorded())
    assert able.ramp_share == pytest.approx(0.75, abs=0.07)
    stated = replace(able, ramp_share=1.0)
    assert stated.driven_as(recorded()).ramp_share == able.ramp_share
    plain, driven = (
        Experiment({}, None, one, recorded().manifest, "d")  # type: ignore[arg-type]
        for one in (stated, able)
    )
    block = next(one for one in blocks_of(able) if one.name == "rates_pz")
    procedure = plain._procedure(steps_of([block]))
    slower, faster = (one.planned(procedure).imu.t[-1] for one in (driven, plain))
    assert slower > faster


def test_a_ramp_of_constant_acceleration_shows_all_of_its_limit():
    able = replace(Abilities.of_recording(recorded()), ramp_share=1.0)
    made = Experiment({}, None, able, recorded().manifest, "d")  # type: ignore[arg-type]
    block = next(one for one in blocks_of(able) if one.name == "rates_pz")
    planned = made.planned(made._procedure(steps_of([block])))
    assert Abilities.of_recording(planned).ramp_share == pytest.approx(1.0, abs=0.1)


@pytest.mark.rehearsal
def test_a_suspected_effect_gets_a_recording_that_would_show_it():
    made = experiment("lever_arm")
    assert set(made.models) == {"lever_arm", NOTHING}
    choice = made.shortest(15.0)
    assert choice.is_enough
    assert 0.0 < choice.minutes <= 15.0
    assert choice.left >= enough(choice.bound)


def test_what_is_left_where_nothing_shows_need_not_show_itself():
    names = dict.fromkeys(("temperature_bias", "thermal_transient"))
    plain = Experiment(names, None, None, None, "d")  # type: ignore[arg-type]
    silent = replace(plain, by_silence="thermal_transient", rivals={NOTHING: None})  # type: ignore[dict-item]
    assert ("thermal_transient", "temperature_bias") in plain.pairs
    assert silent.pairs == (
        ("temperature_bias", "thermal_transient"), ("temperature_bias", NOTHING)
    )  # fmt: skip


class Optimistic(Experiment):
    """Blocks of 100 s that in linear form show 0.6 of what is needed, and in real form 0.45."""

    def _extended(self, chosen, needed, minutes):  # type: ignore[no-untyped-def]
        more = list(chosen)
        while self._share(more) < needed and 100.0 * (len(more) + 1) <= 60.0 * minutes:
            more.append(1)
        return more

    def _share(self, so_far):  # type: ignore[no-untyped-def]
        return 0.6 * len(so_far)

    def _judged(self, chosen):  # type: ignore[no-untyped-def]
        left = 0.45 * len(chosen) * enough(30.0)
        return Choice(None, 100.0 * len(chosen) / 60.0, left, 30.0, left)  # type: ignore[arg-type]


def test_blocks_are_added_until_the_real_form_shows_enough(monkeypatch):
    monkeypatch.setattr("tasks.experiment.choose._total", lambda some: some)
    made = Optimistic({}, None, None, None, "d")  # type: ignore[arg-type]
    assert made.shortest(15.0).minutes == pytest.approx(5.0)
    assert not made.shortest(4.0).is_enough
