"""Every parser with so many inputs, and the page of it."""

import time
from dataclasses import dataclass

from tests.proof.fuzz import answers, frames
from tests.proof.report import line, publish

TEXT = """# Fuzzed parsers

`make prove ARGS="--fuzz {count} --seed {seed}"`: {count:,} inputs for each parser, no crash.

Frames of a unit are damaged between whole ones: a bit, a burst of wrong bits, bytes that are lost,
too many or random, ends that run into the next frame, noise that begins as a frame does. Where the
damage is one run of wrong bits the check sum shows it, and no such frame may be taken. Of other
damage a check sum of n bits takes one in 2ⁿ, and no parser can know: these are counted. An `xor8`
of text lets more through: two equal characters that are lost leave it as it was. A unit that can
send a CRC should; a reading that is far off is found by the checks of its segment.

| parser | inputs | s (CPU) | wrong though shown | wrong of other damage | whole frames lost |
|---|---:|---:|---:|---:|---:|
{rows}
"""


@dataclass(frozen=True)
class Row:
    """One parser: the inputs, processor seconds, and what was wrong."""

    parser: str
    inputs: int
    seconds: float
    wrong: int
    by_chance: int = 0
    lost: int = 0

    def __str__(self) -> str:
        figures = (f"{self.inputs:,}", f"{self.seconds:.0f}", self.wrong)
        return line((self.parser, *figures, self.by_chance, self.lost))


def run_all(count: int, seed: int) -> list[Row]:
    """A row for each parser. Whatever a parser raises ends it."""
    rows = []
    for kind in frames.KINDS:
        began = time.process_time()
        tally = frames.feed(kind, count, seed)
        seconds = time.process_time() - began
        figures = (tally.wrong_though_shown, tally.wrong_by_chance, tally.lost)
        rows.append(Row(kind.name, tally.fed, seconds, *figures))
    for name, feed in answers.KINDS.items():
        began = time.process_time()
        held = feed(count, seed)
        rows.append(Row(name, held.inputs, time.process_time() - began, held.wrong))
    return rows


def run_fuzz(count: int, seed: int, write: bool) -> None:
    """Hold it and print the page; exit 1 where something is wrong. write: into the evidence."""
    rows = run_all(count, seed)
    page = TEXT.format(count=count, seed=seed, rows="\n".join(map(str, rows)))
    publish("fuzz.md", page, write, any(row.wrong for row in rows))
