"""The page of evidence about proposed recordings."""

from collections.abc import Sequence

from tasks.version import code_version
from tests.proof.next.judge import MINUTES, Answer
from tests.proof.report import line, share

THERMAL = ("temperature_bias", "thermal_gradient", "thermal_transient")
FACTOR = 2.0  # of the evidence achieved beside that predicted
TEXT = """# The recording that decides

`make prove ARGS="--next {count} --seed {seed}"`, {version}. Cases are drawn from the seed until so
many of them stay open: a short sequence of the specification (five minutes, of consumer and
industrial grade) of a unit with one effect, which `explain` suspects only, or cannot tell from
another. `next` proposes a recording of at most {minutes:g} min; the plant carries its procedure
out on the same unit with noise of its own; `explain` gets that recording alone. The plant shares
no code with what explains and proposes. {looked}

| | asked | cases | |
|---|--:|--:|--:|
{figures}

`explain` named the effect by itself, or saw nothing, in {closed} cases more. Half of the stations
have a chamber that can be set (0 to 50 °C, said to change by 4 K/min; the plant's is 15 % slower to
10 % faster, and the unit follows by its warm-up's time constant within 25 %). Nothing is proposed
where no recording of the station decides, and the statement then says what would: a table moves no
temperature; and a low-pass departs from a delay only near its corner. Of second order it is late
by √2/(2πf_c), and what is left of it at f beside such a delay is (f/f_c)²/3 of what the delay
shows: χ² of 54 between the two needs 490·(f_c/f)⁴ of the delay itself.

Per minute of the station the proposed recording shows {per_minute:.1f} times the chi-squared
between the competing models that repeating the whole sequence would (median).

| | effect | chamber | open | χ² predicted | achieved | min | base: χ² | min | after it |
|--:|---|---|---|--:|--:|--:|--:|--:|---|
{cases}
"""
LOOKED = "Cases of seeds 1 and 3 were looked at while `next` was made; those of others are unseen."


def page(seed: int, answers: Sequence[Answer]) -> str:
    """The page of all cases that were drawn."""
    opened = [one for one in answers if one.opened]
    ratios = sorted(one.per_minute for one in opened if one.per_minute is not None)
    return TEXT.format(
        count=len(opened), seed=seed, version=code_version(), minutes=MINUTES, looked=LOOKED,
        figures=_figures(opened), closed=len(answers) - len(opened),
        per_minute=ratios[len(ratios) // 2] if ratios else 0.0,
        cases="\n".join(map(_row, opened)),
    )  # fmt: skip


def _figures(opened: Sequence[Answer]) -> str:
    proposed = [one for one in opened if one.is_proposed]
    declared = [one for one in proposed if one.achieved is not None]
    pairs = [one for one in proposed if len(one.opened) > 1]
    single = [one for one in proposed if len(one.opened) == 1]
    thermal = [one for one in opened if one.chamber and one.effect in THERMAL]
    return "\n".join([
        share("a recording is proposed", "", opened, lambda one: one.is_proposed),
        share("the same, of a thermal effect at a station with a chamber", "", thermal,
              lambda one: one.is_proposed),
        share("the right single name after it", "95 %", proposed, lambda one: one.is_right),
        share("the same, of several that were open", "", pairs, lambda one: one.is_right),
        share("the same, of one that was suspected", "", single, lambda one: one.is_right),
        share("a wrong name after it", "", proposed, lambda one: one.is_wrong),
        share(f"evidence within a factor {FACTOR:g}", "90 %", declared, _near),
    ])  # fmt: skip


def _near(one: Answer) -> bool:
    ratio = (one.achieved or 0.0) / (one.predicted or 1.0)
    return 1.0 / FACTOR <= ratio <= FACTOR


def _row(one: Answer) -> str:
    after = "; ".join(" or ".join(names) for names in one.found) or "no name"
    cells = [
        str(one.number), one.effect, "yes" if one.chamber else "", " or ".join(one.opened),
        _number(one.predicted, 0), _number(one.achieved, 0), _number(one.minutes, 1),
        _number(one.repeated, 0), _number(one.base_minutes, 1),
        after if one.is_proposed else "not proposed",
    ]  # fmt: skip
    return line(cells)


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"
