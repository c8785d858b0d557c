"""Holding it: hand analysis first, then every recording explained blind in fresh processes."""

import json
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pyarrow as pa
import pyarrow.parquet as pq
import typer

from schemas.base import Unusable
from schemas.recording import Recording
from schemas.text import Statement as Text
from storage.formats.folder import read_folder
from tasks.rendering import inline, page
from tasks.version import code_version
from tests.proof.real.facts import (
    RECORDINGS,
    SHAFT,
    Answer,
    Claim,
    Fact,
    Judged,
    Recordings,
    doubtful,
    facts_of,
)
from tests.proof.real.hidden import (
    NOT_HIDDEN,
    Hidden,
    Score,
    as_data,
    by_hand,
    hidden_cases,
    scored,
    untouched,
)
from tests.proof.real.pictures import Picture, pictures_of
from tests.proof.study import Out, Seed, bilingual, folder_of, publish, table
from tests.proof.trial.blind import ANSWER, ANSWERS, explain_blind
from tests.proof.trial.blind import RECORDINGS as RECORDINGS_OUT

Facts = tuple[tuple[Fact, tuple[Judged, ...]], ...]
Claims = tuple[tuple[Claim, bool | None], ...]


@dataclass(frozen=True)
class Results:
    """facts with what each of their recordings' answers says; claims with whether still made.

    None: explain failed there. explaining: s, all explanations together.
    """

    seed: int
    code_version: str
    facts: Facts
    claims: Claims
    scores: tuple[Score, ...]
    pictures: tuple[Picture, ...]
    seconds: float
    explaining: float


def run_all(folder: Path, out: Path, seed: int) -> Results:
    """Everything, from the folder of the real recordings; writes recordings/ and answers/ to out.

    Raises Unusable where a recording is missing or not what it should be.
    """
    started = time.perf_counter()
    recordings = {name: _read(folder, name) for name in RECORDINGS}
    cases = hidden_cases(seed)
    asked: dict[str, Recording] = {name: recordings[name] for name in reversed(RECORDINGS)}
    asked["part"] = untouched(folder, SHAFT)
    asked |= {str(number): case.made(folder) for number, case in enumerate(cases)}
    answers = explained(asked, out)
    parts = judged(folder, recordings, cases, answers)
    spent = sum(float(each["seconds"]) for each in answers.values())
    return Results(seed, code_version(), *parts, time.perf_counter() - started, spent)


def judged(
    folder: Path, recordings: Recordings, cases: Sequence[Hidden], answers: Mapping[str, Answer]
) -> tuple[Facts, Claims, tuple[Score, ...], tuple[Picture, ...]]:
    """Facts and claims beside the answers, scores of what was hidden, and the pictures."""
    facts = facts_of(recordings)
    scores = tuple(
        scored(case, answers[str(number)], _base(case, answers), by_hand(case, folder))
        for number, case in enumerate(cases)
    )
    return (
        tuple(
            (each, tuple(each.declared(answers[name]) for name in each.recordings))
            for each in facts
        ),
        tuple((each, _made(each, answers)) for each in doubtful(recordings)),
        scores,
        tuple(pictures_of(recordings, scores)),
    )


def explained(asked: Mapping[str, Recording], out: Path) -> dict[str, Answer]:
    """The answer to each recording, by processes that get its folder and nothing else.

    Their folders are numbered in the order asked, so that the name tells nothing, either.
    """
    labels = {name: f"{number:03d}" for number, name in enumerate(asked, start=1)}
    for name, label in labels.items():
        write(asked[name], out / RECORDINGS_OUT / label)
    explain_blind(out)
    return {
        name: json.loads((out / ANSWERS / label / ANSWER).read_text(encoding="utf-8"))
        for name, label in labels.items()
    }


def write(recording: Recording, folder: Path) -> None:
    """A recording as a `mimu-recording/1` folder, in the place of what is there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    streams = recording.streams()
    for name, stream in streams.items():
        pq.write_table(pa.table({"t": stream.t, **stream.columns}), folder / f"{name}.parquet")
    manifest = recording.manifest.model_copy(
        update={"streams": {name: f"{name}.parquet" for name in streams}}
    )
    (folder / "manifest.json").write_text(
        manifest.model_dump_json(indent=1, exclude_none=True), encoding="utf-8"
    )


def _made(claim: Claim, answers: Mapping[str, Answer]) -> bool | None:
    answer = answers[claim.recording]
    return None if "failed" in answer else claim.made(answer)


def _base(case: Hidden, answers: Mapping[str, Answer]) -> Answer:
    return answers["part" if case.recording == SHAFT else case.recording]


def _read(folder: Path, name: str) -> Recording:
    if not (folder / name).is_dir():
        raise Unusable(
            f"--real {folder}: there is no recording {name}; give the folder that holds "
            f"{', '.join(RECORDINGS)}"
        )
    return read_folder(folder / name)


# What was held on real recordings: a section of a page in both languages, Markdown, and data.

TEMPLATES = Path(__file__).parent / "templates"
TITLE: Text = bilingual("Real recordings with a known secret", "真实记录：已知的秘密")
METHOD: Text = bilingual(
    "Recordings of other people's hardware. First by hand: spectra, means, lags and comparisons "
    "of two units, sharing no code with explain, each effect in two independent ways. Then known "
    "transformations are hidden in them, sizes drawn from a seed, and every recording is "
    "explained in a process that has its folder and nothing else.",
    "他人硬件的真实记录。先作人工分析：谱、均值、滞后与两台产品比对，不与解释程序共用代码，每一因素以两种独立方法验证。"
    "再将已知变换隐藏其中，大小由种子抽取，由只得到该记录文件夹的进程解释。",
)
RULES: Text = bilingual(
    "The untouched recording's answer is the baseline. A hidden transformation is found if its "
    "name is in the answer and what is stated beyond the baseline holds the hidden amount in its "
    "95 % interval. Any other new name is wrong; where nothing can be seen, any new name is.",
    "以未改动记录的解释结果为基线。答案中出现该名称、且超出基线的量的95 %区间包含隐藏值，即为发现；"
    "出现其他新名称为错误；不可见时出现任何新名称均为错误。",
)
FACTS: tuple[Text, ...] = (
    bilingual("what is there", "真实因素"),
    bilingual("recording", "记录"),
    bilingual("by hand", "人工分析"),
    bilingual("a second way", "第二种方法"),
    bilingual("not known", "未知"),
    bilingual("explain says", "解释结果"),
    bilingual("", ""),
)
CLAIMS: tuple[Text, ...] = (
    bilingual("recording", "记录"),
    bilingual("explain says, or said", "解释程序的（曾有）判断"),
    bilingual("it does now", "目前是否作此判断"),
    bilingual("by hand", "人工结论"),
    bilingual("evidence", "依据"),
)
HIDDEN: tuple[Text, ...] = (
    bilingual("recording", "记录"),
    bilingual("hidden", "隐藏的变换"),
    bilingual("size", "大小"),
    bilingual("by hand", "人工分析"),
    bilingual("explain states", "解释程序给出"),
    bilingual("new names", "新名称"),
    bilingual("outcome", "结果"),
    bilingual("s", "s"),
)
REASONS: tuple[Text, ...] = (
    bilingual("recording", "记录"),
    bilingual("transformation", "变换"),
    bilingual("why", "原因"),
)
IN_CHINESE = {
    "right": "正确", "right name, value off": "名称正确，数值有偏", "wrong": "错误",
    "silent": "未提及", "explain failed": "解释程序出错", "true": "真", "false": "假",
    "cannot tell": "无法判断",
    "yes": "是", "no": "否", "a wrong name": "错误名称", "rightly nothing new": "正确：无新发现",
    "missed": "漏检", "found, value right": "发现，数值正确", "found, value off": "发现，数值有偏",
}  # fmt: skip
MADE = {True: "yes", False: "no", None: "explain failed"}


def section(results: Results) -> str:
    """The HTML of it, in both languages, to stand in a page."""
    claims = [
        [claim.recording, claim.what, translated(MADE[made]), translated(claim.truth),
         claim.evidence]
        for claim, made in results.claims
    ]  # fmt: skip
    return page(
        TEMPLATES / "section.html",
        title=TITLE,
        method=METHOD,
        rules=RULES,
        summary=summary(results),
        facts=results.facts,
        fact_columns=FACTS,
        claims=claims,
        claim_columns=CLAIMS,
        hidden=[[translated(cell) for cell in cells(score)] for score in results.scores],
        hidden_columns=HIDDEN,
        reasons=(*NOT_HIDDEN, *_unseen(results)),
        reason_columns=REASONS,
        pictures=results.pictures,
        inline=inline,
        translated=translated,
    )


def real_html(results: Results) -> str:
    """The section as a page of its own."""
    return page(TEMPLATES / "real.html", section=inline(section(results)), results=results)


def markdown(results: Results) -> str:
    """The same as Markdown, in English, without the pictures."""
    facts = [
        [fact.what.en, ", ".join(fact.recordings), f"{fact.how[0].en}: {fact.size[0]}",
         f"{fact.how[1].en}: {fact.size[1]}", fact.unknown.en,
         "; ".join(each.words for each in declared), "; ".join(each.outcome for each in declared)]
        for fact, declared in results.facts
    ]  # fmt: skip
    claims = [
        [claim.recording, claim.what.en, MADE[made], claim.truth, claim.evidence.en]
        for claim, made in results.claims
    ]
    reasons = [[a, b, why.en] for a, b, why in (*NOT_HIDDEN, *_unseen(results))]
    return "\n".join(
        [
            f"# {TITLE.en}", "", METHOD.en, "", *_rows(("", ""), summary(results)),
            "## Really there", "", *_rows(_english(FACTS), facts),
            "## Claims that look doubtful", "", *_rows(_english(CLAIMS), claims),
            "## Hidden", "", RULES.en, "",
            *_rows(_english(HIDDEN), [cells(each) for each in results.scores]),
            "## What cannot be hidden there", "",
            *_rows(_english(REASONS), reasons),
            f"Seed {results.seed}, {results.code_version}.", "",
        ]
    )  # fmt: skip


def data(results: Results) -> dict[str, Any]:
    """`mimu-prove-real/1`."""
    return {
        "format": "mimu-prove-real/1",
        "seed": results.seed,
        "code_version": results.code_version,
        "seconds": results.seconds,
        "explaining_seconds": results.explaining,
        "summary": dict(summary(results)),
        "facts": [
            {"key": fact.key, "what": fact.what.en, "size": list(fact.size),
             "told": {name: vars(one) for name, one in zip(fact.recordings, declared, strict=True)}}
            for fact, declared in results.facts
        ],
        "claims": [
            {"recording": claim.recording, "what": claim.what.en, "made": made,
             "truth": claim.truth, "evidence": claim.evidence.en}
            for claim, made in results.claims
        ],
        "hidden": [as_data(each) for each in results.scores],
    }  # fmt: skip


def summary(results: Results) -> list[tuple[str, str]]:
    """The headline."""
    declared = [each.outcome for _, every in results.facts for each in every]
    made = [claim.truth for claim, is_made in results.claims if is_made]
    observation = [each for each in results.scores if each.visible]
    quiet = [each for each in results.scores if not each.visible]
    by_hand = sum(bool(e.by_hand and _holds(e)) for e in observation)
    return [
        ("real effects that explain tells rightly", _of(declared.count("right"), len(declared))),
        ("  right name, value off", _of(declared.count("right name, value off"), len(declared))),
        ("  wrong", _of(declared.count("wrong"), len(declared))),
        ("doubtful claims that it makes now and are false", _of(made.count("false"), len(made))),
        ("hidden and visible: found, value right",
         _of(sum(e.outcome == "found, value right" for e in observation), len(observation))),
        ("  named", _of(sum(e.named for e in observation), len(observation))),
        ("  a wrong name beside", _of(sum(bool(e.wrong) for e in observation), len(observation))),
        ("  by hand, within 95 %", _of(by_hand, len(observation))),
        ("nothing to see: rightly nothing new",
         _of(sum(e.outcome == "rightly nothing new" for e in quiet), len(quiet))),
        ("in all", f"{results.seconds:.0f} s, of it explaining {results.explaining:.0f} s"),
    ]  # fmt: skip


def cells(score: Score) -> list[str]:
    """A row of the table of what was hidden."""
    size, case = score.case.size, score.case
    at = f" at {size.at:g} s" if size.at else ""
    return [
        case.recording,
        case.name if case.why is None else f"{case.name} (cannot be seen)",
        f"{size.value:.4g}{'' if size.unit == '1' else ' ' + size.unit}{at}",
        str(score.by_hand or "—"),
        str(score.stated or "—"),
        ", ".join(score.new) or "—",
        score.outcome,
        f"{score.seconds:.0f}",
    ]


def _unseen(results: Results) -> list[tuple[str, str, Text]]:
    """Of what was hidden though it cannot be seen: recording, transformation, why; once each."""
    declared = {(e.case.recording, e.case.name): e.case.why for e in results.scores if e.case.why}
    return [(recording, name, why) for (recording, name), why in declared.items()]


def _holds(score: Score) -> bool:
    hand = score.by_hand
    return hand is not None and abs(hand.value - score.case.size.value) <= 2.0 * hand.u


def translated(words: str) -> Text:
    """Words of the tables in both languages, where they are not names or numbers."""
    return bilingual(words, IN_CHINESE.get(words, words))


def _english(texts: Sequence[Text]) -> list[str]:
    return [text.en for text in texts]


def _of(count: int, of: int) -> str:
    return f"{count} of {of}"


def _rows(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [*table(head, rows), ""]


def real(
    recordings: Annotated[Path, typer.Argument(metavar="FOLDER", help="Of real recordings.")],
    seed: Seed = 1, out: Out = None,
) -> None:  # fmt: skip
    """Real recordings, by hand and with known changes hidden in them."""
    folder = folder_of("real", out)
    publish("real", markdown(held(recordings, folder, seed)), folder)


def held(recordings: Path, folder: Path, seed: int) -> Results:
    """Hand analysis, known transformations hidden, explained blind and scored.

    Writes recordings, answers, real.json and real.html to the folder. Raises Unusable where one of
    the recordings is missing or broken.
    """
    results = run_all(recordings, folder, seed)
    response = json.dumps(data(results), indent=1, ensure_ascii=False) + "\n"
    (folder / "real.json").write_text(response, encoding="utf-8")
    (folder / "real.html").write_text(real_html(results), encoding="utf-8")
    return results
