"""The Mismatch page: which physics is missing, on which station, unit and model, and since when."""

from flows.pages.discrepancy.data import data
from flows.pages.discrepancy.layout import layout
from flows.pages.discrepancy.models import DiscrepancyQuestion, DiscrepancyShown
from flows.pages.page import Page

PAGE = Page("mismatch", DiscrepancyQuestion, DiscrepancyShown, data, layout)
