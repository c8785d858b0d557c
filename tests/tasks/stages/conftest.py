"""A home of its own for each test."""

import pytest

from storage.home import Home


@pytest.fixture
def home(fresh) -> Home:
    return fresh
