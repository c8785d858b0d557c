"""The Do page: start a run, re-process, draft, check, issue and withdraw, as the role allows."""

from flows.pages.do.actions import DoQuestion, DoShown
from flows.pages.do.page import callbacks, data, layout
from flows.pages.parts import Page

PAGE = Page("do", DoQuestion, DoShown, data, layout, callbacks=callbacks)
