"""What the proof's pages say: each text in English and in Chinese."""

Text = tuple[str, str]
