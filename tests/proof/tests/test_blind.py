"""What answers a trial knows nothing of what made it: in one process, which takes a while."""

import json
import subprocess
import sys

KNOWS = """
import json, sys

def loaded(*beginnings):
    return [name for name in sys.modules if name.startswith(beginnings)]

import tests.proof.real.hide
from tests.proof.real.hand import measured, rests, shaft
judged = ("tasks.explain", "tasks.model", "tasks.motion", "tasks.segments", "tasks.specifications")
hand = loaded(*judged)
import tests.proof.peers.answer
peers = loaded("tests.proof.plant", "tests.proof.trial")
import tasks.explain.explain, tasks.explain.report, tests.proof.trial.blind
explain = loaded("tests.proof.plant")
print(json.dumps({"hand": hand, "peers": peers, "explain": explain}))
"""


def test_hand_shares_no_code_with_what_it_judges_and_what_answers_holds_none_of_the_plant() -> None:
    done = subprocess.run(
        [sys.executable, "-c", KNOWS], capture_output=True, text=True, timeout=600, check=True
    )
    assert json.loads(done.stdout) == {"hand": [], "peers": [], "explain": []}
