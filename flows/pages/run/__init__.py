"""The page of one run: signals, segments, items, certificates, log and lineage."""

from flows.pages.parts import Page
from flows.pages.run.data import RunQuestion, RunShown, data
from flows.pages.run.page import callbacks, layout

PAGE = Page("run", RunQuestion, RunShown, data, layout, in_navigation=False, callbacks=callbacks)
