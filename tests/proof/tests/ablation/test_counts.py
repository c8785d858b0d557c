"""Lines, numeric constants and names of effects are counted as they stand in the text."""

from pathlib import Path

from tests.proof.ablation.counts import Counts, counts

TEXT = '''"""A rule."""

NEAR, FAR = 0.5, 2.0
HALF = 0.5 * NEAR
FIRM = True
WORD = "lever arm"
ARM = "lever_arm"


def rule(name):
    return name in ("size_effect", "unnamed")
'''


def test_what_counts_and_what_does_not(tmp_path: Path):
    (tmp_path / "rule.py").write_text(TEXT, encoding="utf-8")
    assert counts(tmp_path) == Counts(lines=8, constants=3, names=2, files=1)


def test_the_file_that_finds_an_event_may_name_it(tmp_path: Path):
    (tmp_path / "events").mkdir()
    (tmp_path / "events" / "zone.py").write_text('NAME = "dead_zone"\n', encoding="utf-8")
    assert counts(tmp_path).names == 0
