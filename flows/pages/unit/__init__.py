"""The page of one unit: every coefficient over the years, drift, certificates and next due date."""

from flows.pages.parts import Page
from flows.pages.unit.data import UnitQuestion, UnitShown, data
from flows.pages.unit.page import layout

PAGE = Page("unit", UnitQuestion, UnitShown, data, layout, has_grid=True)
