import pytest

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Mount, Station, TableAxis, Unit
from schemas.station import StationFile
from tasks.station import procedures
from tasks.station.requirements import check_procedure
from tests.tasks.station.sample_stations import rates_link, sample

JJF2003 = procedures.load("jjf2003")
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
