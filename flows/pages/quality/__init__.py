"""The Quality page: yield, failures, capability, control charts and stations of selected runs."""

from flows.pages.parts import Page
from flows.pages.quality.data import NUMBERS, QualityQuestion, QualityShown, callbacks, data
from flows.pages.quality.page import layout

PAGE = Page(
    "quality", QualityQuestion, QualityShown, data, layout, callbacks=callbacks, numbers=NUMBERS
)
