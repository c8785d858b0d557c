import pytest

from schemas.base import Unusable
from schemas.limits import Limits
from schemas.procedure import Procedure
from schemas.recording import Mount, Station, TableAxis, Unit
from schemas.station import StationFile
from tasks.station import procedures
from tasks.station.requirements import check_limits, check_procedure
from tasks.station.virtual.config import VirtualStation, station_file
from tests.tasks.station.sample_stations import rates_link, sample

# A procedure against the limits of table, fixture and chamber.

JJF2003 = procedures.load("jjf2003")


def limited(limits: dict[str, object]) -> StationFile:
    station = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
    return station.model_copy(update={"limits": Limits.model_validate(limits)})


def outer(**limits: object) -> dict[str, object]:
    return {"axes": {"outer": limits}}


@pytest.mark.parametrize(
    "limits",
    [
        {},
        outer(rate_deg_s=1000.0, acceleration_deg_s2=2000.0),
        {"axes": {"middle": {"angle_deg": (-180.0, 270.0)}}},
    ],
)
def test_a_procedure_within_the_limits_is_let_through(limits):
    check_limits(JJF2003, limited(limits))


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        (outer(rate_deg_s=5.0), r"needs \d+ deg/s \(limit 5\) about axis outer, and axis outer"),
        (outer(acceleration_deg_s2=1.0), r"needs \d+ deg/s2 \(limit 1\) about axis outer"),
        (outer(angle_deg=(-400.0, 400.0)), r"turns without end \(limit -400 to 400 deg\)"),
        (
            {"axes": {"middle": {"angle_deg": (-10.0, 10.0)}}},
            r"needs 90 deg \(limit -10 to 10 deg\) about",
        ),
        ({"fixture": {"rate_deg_s": 200.0}}, r"segment rate_x_\S+ .* and the fixture of station"),
        ({"axes": {"roll": {}}}, "names roll, and the table has the axes outer, middle, inner"),
    ],
)
def test_what_is_too_much_is_named_with_its_segment_and_limit(limits, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_limits(JJF2003, limited(limits))


def heated(degc: float) -> Procedure:
    steps = JJF2003.steps[:2]
    hot = steps[1].model_copy(update={"chamber_degc": degc})
    return JJF2003.model_copy(update={"steps": (steps[0], hot)})


@pytest.mark.parametrize(
    ("limits", "sentence"),
    [
        ({}, r"position_\+x_\S+ .* sets the chamber to 45 °C, and .* has no limits.chamber"),
        (
            {"chamber": {"temperature_degc": (5.0, 40.0), "rate_k_min": 3.0}},
            r"sets the chamber to 45 °C, and limits.chamber of station \S+ allows 5 to 40 °C",
        ),
    ],
)
def test_a_temperature_that_the_chamber_may_not_have_is_refused(limits, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_limits(heated(45.0), limited(limits))


def test_limits_of_a_chamber_that_cannot_be_set_are_refused():
    fields = sample()
    del fields["chamber"]["commands"]
    with pytest.raises(ValueError, match=r"chamber\.commands has no set_temperature"):
        StationFile.model_validate(fields)


def test_turns_count_from_where_they_begin_to_where_they_end():
    values = procedures.load("jjf1536").model_dump()
    turns = next(step for step in values["steps"] if step["kind"] == "turns")
    only = Procedure.model_validate(values | {"steps": [turns]})
    axes = len(turns["angles_deg"])
    assert axes == 1
    station = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
    end = turns["angles_deg"][0] + 360.0 * turns["turns"]
    name = station.station.table_axes[0].name

    def check(most_deg: float) -> None:
        limits = Limits.model_validate({"axes": {name: {"angle_deg": (-end, most_deg)}}})
        check_limits(only, station.model_copy(update={"limits": limits}))

    check(end)
    with pytest.raises(Unusable, match=f"needs {end:g} deg"):
        check(end - 1.0)


Z, X = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def station(*directions: tuple[float, float, float], mount: Mount | None = None) -> StationFile:
    axes = [TableAxis(name=f"axis{n}", direction=way) for n, way in enumerate(directions)]
    return StationFile(
        table=sample()["table"],
        chamber=sample()["chamber"],
        unit_link=rates_link(),
        station=Station(id="T3", table_axes=tuple(axes) or None),
        mount=mount or Mount(),
        unit=Unit(manufacturer="m", model="m", serial="s"),
    )


def changed(place: int, **fields: object) -> Procedure:
    steps = list(JJF2003.steps)
    steps[place] = steps[place].model_copy(update=fields)
    return JJF2003.model_copy(update={"steps": tuple(steps)})


def test_unit_mounted_a_quarter_turn_off_is_refused():
    quarter = 0.5**0.5  # body y lies along payload x
    turned = station(Z, X, Z, mount=Mount(quaternion_wxyz=(quarter, 0.0, 0.0, -quarter)))
    with pytest.raises(Unusable, match=r"position_\+x_000 .* says \+x up, .* bring \+y up"):
        check_procedure(JJF2003, turned)


@pytest.mark.parametrize(
    ("procedure", "bench", "sentence"),
    [
        (JJF2003, station(), "lists no station.table_axes"),
        (JJF2003, station(Z), "gives 3 angles and station T3 has 1 axes"),
        (JJF2003, station(Z, Z, Z), r"says \+x up, and its angles_deg bring \+z up"),
        (JJF2003, station((0.0, 0.0, -1.0), X, Z), "says it turns about x, .* about -x there"),
        (changed(1, name="position_+x_000"), station(Z, X, Z), "2 segments named"),
        (changed(13, spin_axis=3), station(Z, X, Z), "spins axis 3 and the table has axes 0 to 2"),
        (changed(13, rates_deg_s=(-1.0, 0.0)), station(Z, X, Z), "has a rate of 0"),
        (changed(13, axis="y"), station(Z, X, Z), r"says it turns about y, .* about \+x there"),
    ],
)
def test_what_the_station_cannot_do_is_refused_with_the_step(procedure, bench, sentence):
    with pytest.raises(Unusable, match=sentence):
        check_procedure(procedure, bench)
