"""An alert reaches the operators of recall.toml on every channel, at any hour."""

import pytest

from schemas.base import Unusable
from storage.home import Home
from tasks.stages.remind import Sent, alert

FILE = """
format = "mimu-recall/1"
[silent]
since = "00:00"
until = "23:59:59"
timezone = "Asia/Shanghai"
[operators]
language = "zh"
channels = { mail = "json://localhost:9", chat = "json://localhost:10" }
"""


def test_each_channel_gets_the_sentence_and_a_fault_of_one_is_no_fault_of_another(tmp_path):
    (tmp_path / "recall.toml").write_text(FILE)
    sent = []

    def send(url: str, title: str, body: str, entry: bytes | None) -> str | None:
        sent.append((title, body, entry))
        return "refused" if url.endswith(":9") else None

    done = alert(Home(tmp_path), "Station T1 is silent.", send)
    assert done == [Sent("mail", "refused"), Sent("chat", None)]
    assert sent == [("mimucal：需要处理", "Station T1 is silent.", None)] * 2


@pytest.mark.parametrize("text", [None, 'format = "mimu-recall/1"\n'])
def test_without_operators_it_says_where_to_name_them(tmp_path, text):
    if text:
        (tmp_path / "recall.toml").write_text(text)
    with pytest.raises(Unusable, match=r"recall\.toml names no operators"):
        alert(Home(tmp_path), "Nobody hears it.")
