"""What the proof's pages say: each text in English and in Chinese."""

from schemas.text import Statement

Text = Statement


def bilingual(en: str, zh: str) -> Text:
    """A text in both languages."""
    return Statement(en=en, zh=zh)
