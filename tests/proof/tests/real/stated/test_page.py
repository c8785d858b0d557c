"""The page counts claims and says what each recording cost."""

import json
import sys
from pathlib import Path

from tests.proof.real.stated.judge import Judged
from tests.proof.real.stated.page import Answered, data, markdown
from tests.proof.real.stated.run import Cost, explained

ANSWER = {"verdict": "explained", "explained_share": 0.9, "findings": [{"effect": "unnamed"}]}
CLAIMS = (
    Judged("rig", "time_offset", 0.9, "right", "late"),
    Judged("rig", "a|b", None, "wrong", "not there"),
)
EVERY = [
    Answered("rig", ANSWER, CLAIMS, Cost(8.0, 500.0), Cost(18.0, 600.0)),
    Answered("hand", None, (), Cost(2.0, 200.0), None),
]


def test_the_page_counts_claims_and_costs() -> None:
    page = markdown(EVERY, "1")
    assert "2 claims: 1 right, 1 wrong, 0 not known." in page
    assert "| rig | 18.0 | 8.0 | 600 | 500 | 90 % | 1 |" in page
    assert "| hand | — | 2.0 | — | 200 | refused | 0 |" in page
    assert "a/b" in page


def test_the_data_has_every_claim_and_cost() -> None:
    rig, hand = json.loads(json.dumps(data(EVERY, "1")))["recordings"]
    assert [claim["judgement"] for claim in rig["claims"]] == ["right", "wrong"]
    assert rig["cost"]["seconds"] < rig["before"]["seconds"]
    assert hand["verdict"] is None


def test_what_a_program_says_and_costs_is_kept(tmp_path: Path) -> None:
    code = "import sys; b = bytearray(50_000_000); sum(range(10**6)); print('{\"verdict\": 1}')"
    answer, cost = explained(Path("rig"), tmp_path, (sys.executable, "-c", code))
    assert answer == {"verdict": 1}
    assert cost.seconds > 0.0
    assert cost.memory > 47.0


def test_a_refused_recording_has_no_answer(tmp_path: Path) -> None:
    answer, _ = explained(Path("rig"), tmp_path, (sys.executable, "-c", "raise SystemExit(2)"))
    assert answer is None
