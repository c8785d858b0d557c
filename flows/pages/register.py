"""The pages, in the order in which the navigation shows them."""

from flows.pages import line, runs
from flows.pages.page import Page

PAGES: tuple[Page, ...] = (line.PAGE, runs.PAGE)
FIRST = PAGES[0]  # what the bare address shows
