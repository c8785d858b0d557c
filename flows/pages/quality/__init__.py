"""The Quality page: yield, capability, control chart and stations of the selected runs."""

from flows.pages.page import Page
from flows.pages.quality.data import data
from flows.pages.quality.layout import callbacks, layout
from schemas.pages.quality import QualityQuestion, QualityShown

PAGE = Page("quality", QualityQuestion, QualityShown, data, layout, callbacks=callbacks)
