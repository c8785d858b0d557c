"""The page of one unit: every coefficient over the years, drift, certificates and next due date."""

from flows.pages.page import Page
from flows.pages.unit.data import data
from flows.pages.unit.layout import layout
from flows.pages.unit.models import UnitQuestion, UnitShown

PAGE = Page("unit", UnitQuestion, UnitShown, data, layout, has_grid=True)
