"""Lets the tests of this folder import the run on a table above them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
