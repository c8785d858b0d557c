"""Runs: every run of the store with the state of its steps."""

import dash_mantine_components as dmc
import sqlalchemy as sql
from dash.development.base_component import Component

from flows.pages.page import Page, View
from schemas.pages.runs import RunLine, RunsQuestion, RunsShown
from storage.catalogue import database, tables
from storage.catalogue.completion import complete_runs
from storage.home import Home
from tasks.words import message


def data(question: RunsQuestion, home: Home) -> RunsShown:
    """Rows of the list of runs, from the catalogue alone."""
    complete_runs(home)
    run = tables.runs.c
    counted = database.rows(home, sql.select(sql.func.count()).select_from(tables.runs))
    asked = database.of_units(RunLine, tables.runs, sql.true())
    newest_first = asked.order_by(run.taken_in_at.desc(), run.id)
    found = database.rows(home, newest_first.offset(question.start).limit(question.count))
    lines = (RunLine.model_validate(row, from_attributes=True) for row in found)
    return RunsShown(total=counted[0][0] if counted else 0, runs=tuple(lines))


def layout(shown: RunsShown, view: View) -> Component:
    """The list as a table."""
    if not shown.runs:
        return dmc.Text(view.say(message("pages-runs-none")))
    rows = [[run.id, run.serial, run.station, str(run.recorded_on)] for run in shown.runs]
    return dmc.Table(data={"body": rows}, striped=True)


PAGE = Page("runs", RunsQuestion, RunsShown, data, layout)
