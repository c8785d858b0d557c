"""Makes recordings of the virtual station, has them explained blind, and scores the answers."""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from tasks.version import code_version
from tests.proof.real.run import write
from tests.proof.report import table
from tests.proof.station.case import Case, cases
from tests.proof.station.record import recording_of
from tests.proof.station.score import Score, score
from tests.proof.trial.blind import ANSWER
from tests.proof.trial.seal import ANSWERS, RECORDINGS, explain_blind

COLUMNS = ("recording", "low-pass", "delay", "wrong names", "told", "s")


def run_all(folder: Path, count: int, report: Callable[[int, int], None]) -> list[Score]:
    """Recordings, answers, station.md and station.json in a new folder; the scores of the first
    `count` cases.
    """
    asked = {f"{number:03d}": case for number, case in enumerate(cases(count), start=1)}
    for label, case in asked.items():
        write(recording_of(case), folder / RECORDINGS / label)
    explain_blind(folder, report)
    scores = [score(case, _answer(folder / ANSWERS / label)) for label, case in asked.items()]
    (folder / "station.md").write_text(as_markdown(scores), encoding="utf-8")
    data = json.dumps(as_data(scores), indent=1, ensure_ascii=False) + "\n"
    (folder / "station.json").write_text(data, encoding="utf-8")
    return scores


def _answer(folder: Path) -> dict[str, object]:
    return dict(json.loads((folder / ANSWER).read_text(encoding="utf-8")))


def as_markdown(scores: Sequence[Score]) -> str:
    """What came out in all, then a row for each recording."""
    return "\n".join([*summary(scores), "", *table(COLUMNS, map(_row, scores)), ""])


def summary(scores: Sequence[Score]) -> list[str]:
    """Of all recordings: wrong names, and how low-pass and delay were told."""
    lines = [
        f"{len(scores)} recordings of the virtual station: right in "
        f"{sum(one.is_right for one in scores)} "
        f"({sum(one.is_right and one.is_silent for one in scores)} of them by silence, where "
        f"`explain` looks at nothing that would show it), a wrong name in "
        f"{sum(bool(one.wrong) for one in scores)}, failed "
        f"{sum(one.failed is not None for one in scores)}; "
        f"{sum(one.case.is_loaded for one in scores)} by a busy computer."
    ]
    for what in ("low_pass", "delay"):
        declared = Counter(getattr(one, what) for one in scores)
        counts = ", ".join(f"{how} {n}" for how, n in declared.most_common())
        lines.append(f"{what.replace('_', '-')}: {counts}.")
    return lines


def as_data(scores: Sequence[Score]) -> dict[str, object]:
    """What station.md says, and of each recording the truth beside what was said of it."""
    return {
        "code_version": code_version(),
        "summary": summary(scores),
        "recordings": [_data(one) for one in scores],
    }


def _data(one: Score) -> dict[str, object]:
    case = one.case
    return {
        "name": case.name, "is_loaded": case.is_loaded, "corners_hz": case.corners_hz,
        "delay_s": case.delay_s, "group_delays_s": case.group_delays_s, "is_right": one.is_right,
        "low_pass": one.low_pass, "delay": one.delay, "wrong": one.wrong, "told": one.names,
        "failed": one.failed, "seconds": round(one.seconds, 2),
    }  # fmt: skip


def _row(one: Score) -> tuple[str, ...]:
    return (
        _described(one.case), one.low_pass, one.delay, ", ".join(one.wrong) or "none",
        one.failed or ", ".join(one.names) or "nothing", f"{one.seconds:.1f}",
    )  # fmt: skip


def _described(case: Case) -> str:
    corners = " / ".join(f"{hz:.0f}" for hz in case.corners_hz or ())
    return f"{case.name} ({corners or 'no'} Hz, {1e3 * case.delay_s:.1f} ms)"
