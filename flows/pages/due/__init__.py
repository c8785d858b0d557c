"""The Due page: recalibration calendar, messages to clients, and the laboratory's equipment."""

from flows.pages.due.data import data
from flows.pages.due.layout import layout
from flows.pages.due.models import DueQuestion, DueShown
from flows.pages.page import Page

PAGE = Page("due", DueQuestion, DueShown, data, layout, has_grid=True)
