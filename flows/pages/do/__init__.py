"""The Do page: start a run, re-process, draft, check, issue and withdraw, as the role allows."""

from flows.pages.do.layout import callbacks, data, layout
from flows.pages.do.models import DoQuestion, DoShown
from flows.pages.page import Page

PAGE = Page("do", DoQuestion, DoShown, data, layout, callbacks=callbacks)
