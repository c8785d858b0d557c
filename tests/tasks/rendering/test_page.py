"""A page has every language, escapes what it is given, and needs nothing from elsewhere."""

from pathlib import Path

import pytest

from schemas.text import Statement
from tasks.rendering import draw, inline, page

TITLE = Statement(en="a < b", zh="甲 < 乙")


@pytest.fixture
def template(tmp_path) -> Path:
    path = tmp_path / "page.html"
    path.write_text(
        '{% extends "base.html" %}{% from "macros.html" import table %}'
        "{% block title %}T{% endblock %}{% block main %}"
        "<h1>{{ title | text }}</h1>{{ picture }}"
        '{{ table([], [[title, "x & y"]], [1]) }}{% endblock %}'
    )
    return path


def test_a_text_stands_in_every_language_and_is_escaped(template):
    html = page(template, title=TITLE, picture="<svg>")
    both = '<span lang="en">a &lt; b</span><span lang="zh">甲 &lt; 乙</span>'
    assert f"<h1>{both}</h1>&lt;svg&gt;" in html
    assert f'<td class="name">{both}</td><td class="number">x &amp; y</td>' in html
    assert html.count('<input class="language"') == 2


def test_what_a_template_needs_and_is_not_given_is_an_error(template):
    with pytest.raises(Exception, match="picture"):
        page(template, title=TITLE)


def test_a_chart_is_the_same_each_time_and_stands_in_a_page_as_it_is(template):
    def content(figure) -> None:
        figure.subplots().plot([1, 2, 3], label="x")

    first, second = (draw("<rising>", 300, 200, content) for _ in range(2))
    assert first == second
    assert first.startswith('<svg role="img" aria-label="&lt;rising&gt;"')
    assert 'viewBox="0 0 300 200"' in first
    assert first in page(template, title=TITLE, picture=inline(first))
