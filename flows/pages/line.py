"""Line: what each station does now, from the status that its run keeps."""

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.page import Page, View
from schemas.pages.line import LineNow, LineQuestion, StationNow
from storage.home import Home
from storage.run_status import statuses
from tasks.words import message


def data(_: LineQuestion, home: Home) -> LineNow:
    """The last run of each station."""
    found = statuses(home)
    return LineNow(
        stations=tuple(StationNow(status=status, is_dead=is_dead) for status, is_dead in found)
    )


def layout(line: LineNow, view: View, _: LineQuestion) -> Component:
    """A card for each station."""
    if not line.stations:
        return dmc.Text(view.say(message("pages-line-no-station")))
    return dmc.SimpleGrid([_card(each) for each in line.stations], cols={"base": 1, "sm": 2})


def _card(now: StationNow) -> Component:
    status = now.status
    return dmc.Card(
        [dmc.Text(status.station, fw="bold"), dmc.Text(status.now)], withBorder=True, padding="md"
    )


PAGE = Page("line", LineQuestion, LineNow, data, layout, refresh_s=2.0)
