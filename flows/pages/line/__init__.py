"""The Line page: what each station is doing, what is to be seen to, what waits, and the day."""

from flows.pages.line.data import LineNow, LineQuestion, line_now
from flows.pages.line.page import layout
from flows.pages.parts import Page

REFRESH_S = 2.0

PAGE = Page("line", LineQuestion, LineNow, line_now, layout, refresh_s=REFRESH_S)
