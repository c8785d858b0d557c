"""The Line page: what each station is doing, what is to be seen to, what waits, and the day."""

from flows.pages.line.data import data
from flows.pages.line.layout import layout
from flows.pages.page import Page
from schemas.pages.line import LineNow, LineQuestion

REFRESH_S = 2.0

PAGE = Page("line", LineQuestion, LineNow, data, layout, refresh_s=REFRESH_S)
