"""Answers that are kept while nothing is written."""

from storage.catalogue.unchanged import version, while_unchanged
from storage.catalogue.users import add, users
from storage.home import Home


def test_an_answer_is_asked_for_again_after_a_write_and_only_then(tmp_path) -> None:
    asked = []

    @while_unchanged(4)
    def names(prefix: str, home: Home) -> list[str]:
        asked.append(prefix)
        return [name for name in users(home) if name.startswith(prefix)]

    home = Home(tmp_path / "home")
    assert names("L", home) == []
    add("Li", "viewer", "hash", home, "Chen")
    assert names("L", home) == ["Li"]
    assert names("L", home) == ["Li"]
    assert names("W", home) == []
    assert asked == ["L", "L", "W"]


def test_homes_do_not_share_answers(tmp_path) -> None:
    assert version(Home(tmp_path / "a")) != version(Home(tmp_path / "b"))
