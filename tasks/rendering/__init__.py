"""Pages to read: templates in every language, and charts for them, each file complete in itself."""

from tasks.rendering.chart import draw
from tasks.rendering.page import inline, page

__all__ = ["draw", "inline", "page"]
