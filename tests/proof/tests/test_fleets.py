"""The judge of fleets: what is drawn, and what counts as right."""

from functools import cache

from schemas.discrepancy import Carrier, Detection, PooledEvidence, Review, ReviewFinding
from schemas.text import Statement
from tests.proof.fleets import Fleet, carrier_name, draw, judged, manifest_of_run

WORDS = Statement(en="", zh="")
EVIDENCE = PooledEvidence(delta_bic=50.0, per_run_z_median=3.0, runs_that_show_it=9, runs=9)


def found(effect: str, level: str, carrier: str, *names: str, **more: object) -> ReviewFinding:
    return ReviewFinding.model_validate({
        "effect": effect, "level": level, "carrier": carrier, "parameters": (),
        "evidence": EVIDENCE, "indistinguishable_from": names, "statement": WORDS, **more,
    })  # fmt: skip


def review(*findings: ReviewFinding) -> Review:
    detection = Detection(p_value=0.5, false_alarm_rate=0.01)
    return Review(
        runs=50, verdict="explained", detection=detection, findings=findings, statement=WORDS
    )


drawn = cache(draw)


def of_kind(kind: str) -> Fleet:
    return next(fleet for fleet in (drawn(1, n) for n in range(40)) if fleet.kind == kind)


def test_a_fleet_is_the_same_whenever_it_is_drawn() -> None:
    assert draw(1, 1) == drawn(1, 1)
    assert draw(2, 1) != drawn(1, 1)


def test_right_is_the_carrier_and_the_name() -> None:
    fleet = of_kind("station")
    assert fleet.effect is not None
    name, carrier = fleet.effect.name, carrier_name(fleet)
    assert judged(fleet, review(found(name, "station", carrier))).single
    assert not judged(fleet, review(found(name, "station", "elsewhere"))).right
    assert not judged(fleet, review()).right
    pair = judged(fleet, review(found("bandwidth", "station", carrier, name)))
    assert (pair.right, pair.single, pair.wrong) == (True, False, ())
    alternatives = (Carrier(level="station", carrier=carrier, delta_bic=1.0),)
    among = judged(fleet, review(found(name, "site", "x", alternatives=alternatives)))
    assert (among.right, among.single) == (True, False)


def test_another_name_is_wrong_and_any_in_a_clean_fleet_an_alarm() -> None:
    carried, clean = of_kind("station"), of_kind("clean")
    assert judged(carried, review(found("bandwidth", "station", "x"))).wrong == ("bandwidth",)
    assert judged(clean, review(found("bandwidth", "station", "x"))).alarms == 1
    assert judged(clean, review()).alarms == 0


def test_since_when_is_counted_in_runs_of_the_carrier() -> None:
    fleet = of_kind("station_since")
    assert fleet.effect is not None
    assert fleet.since is not None
    own = [run for run in fleet.runs if run.station == fleet.carrier]
    run = manifest_of_run(fleet, own[fleet.since + 1]).recording_id
    since = {"run": run, "at": "", "earliest": "", "latest": ""}
    finding = found(fleet.effect.name, "station", carrier_name(fleet), since=since)
    assert judged(fleet, review(finding)).since_off == 1
