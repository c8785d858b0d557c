"""Whether the libraries are there that the peers need: they come with an extra of their own."""

from importlib.util import find_spec

from tests.proof.text import Text, bilingual

NEEDED = ("sklearn", "pysindy")
MISSING: Text = bilingual(
    "The peers were left out: pysindy or scikit-learn is missing; "
    "`.venv/bin/python -m pip install -e '.[peers]'` brings them.",
    "未与其他方法对比：缺少 pysindy 或 scikit-learn；可用 "
    "`.venv/bin/python -m pip install -e '.[peers]'` 安装。",
)


def peers_installed() -> bool:
    """False: `MISSING` says what to do."""
    return all(find_spec(name) is not None for name in NEEDED)
