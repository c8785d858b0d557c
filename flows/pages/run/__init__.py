"""The page of one run: signals, segments, items, certificates, log and lineage."""

from flows.pages.page import Page
from flows.pages.run.data import data
from flows.pages.run.layout import callbacks, layout
from flows.pages.run.models import RunQuestion, RunShown

PAGE = Page("run", RunQuestion, RunShown, data, layout, in_navigation=False, callbacks=callbacks)
