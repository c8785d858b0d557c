"""deploy/guide/settings.md is what the models say."""

from deploy.settings_page import PAGE, text
from schemas.laboratory import variables


def test_the_page_of_settings_is_that_of_the_models():
    assert PAGE.read_text(encoding="utf-8") == text()  # else: python deploy/settings_page.py


def test_every_variable_is_on_the_page():
    assert all(f"| `{name}` |" in text() for name in variables().values())
