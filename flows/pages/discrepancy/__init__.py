"""The Mismatch page: which physics is missing, on which station, unit and model, and since when."""

from flows.pages.discrepancy.data import DiscrepancyQuestion, DiscrepancyShown, data
from flows.pages.discrepancy.page import layout
from flows.pages.parts import Page

PAGE = Page("mismatch", DiscrepancyQuestion, DiscrepancyShown, data, layout)
