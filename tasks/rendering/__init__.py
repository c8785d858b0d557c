"""Pages and charts: templates in every language, every file complete in itself."""

from tasks.rendering.chart import draw
from tasks.rendering.page import inline, inline_each, page

__all__ = ["draw", "inline", "inline_each", "page"]
