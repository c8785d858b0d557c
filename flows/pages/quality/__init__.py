"""The Quality page: yield, failures, capability, control charts and stations of selected runs."""

from flows.pages.page import Page
from flows.pages.quality.choices import callbacks
from flows.pages.quality.data import data
from flows.pages.quality.layout import layout
from flows.pages.quality.models import QualityQuestion, QualityShown
from flows.pages.quality.numbers import NUMBERS

PAGE = Page(
    "quality", QualityQuestion, QualityShown, data, layout, callbacks=callbacks, numbers=NUMBERS
)
