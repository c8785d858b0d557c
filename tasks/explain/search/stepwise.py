"""Effects are added one at a time until what is left is noise; then the list is put right."""

from collections.abc import Sequence
from dataclasses import dataclass

from tasks.explain.regression.spectrum import Noise
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.pool import Pool, System, noises_of, system
from tasks.explain.search.rank import Scored, members_of, rank

FALSE_ALARMS = 0.005  # of clean recordings, at most
MOST = 8  # findings


@dataclass(frozen=True)
class Chosen:
    """A candidate that was taken; rivals: other names that fit nearly as well, best first.

    instead_of: the standard's term that soaks it up whole, where that is why it was taken.
    """

    candidate: Candidate
    gain: float
    score: float
    rivals: tuple[Scored, ...]
    instead_of: str | None = None


@dataclass(frozen=True)
class Found:
    """What the search found. p_value: of the strongest candidate at first, Bonferroni-corrected."""

    chosen: tuple[Chosen, ...]
    noises: tuple[Noise, ...]
    p_value: float
    state: System


def search(
    pool: Pool,
    candidates: Sequence[Candidate],
    start: Sequence[Candidate] = (),
    noises: tuple[Noise, ...] | None = None,
) -> Found:
    """The list of candidates that explains the pool's readings.

    start, noises: what an earlier search found.
    """
    chosen = list(start)
    if noises is None:
        noises = first_noises(pool)
    p_value = 1.0
    before = {frozenset(one.key for one in chosen)}
    while len(chosen) < MOST:
        state = system(pool, noises)
        ranked = rank(state, candidates, chosen)
        if not ranked:
            break
        corrected = min(1.0, ranked[0].p_value * len(candidates))
        if not chosen:
            p_value = corrected
        if corrected > FALSE_ALARMS:
            break
        chosen.append(ranked[0].candidate)
        noises = beside(pool, chosen, noises)
        chosen = _put_right(system(pool, noises), candidates, chosen)
        noises = beside(pool, chosen, noises)
        standing = frozenset(one.key for one in chosen)
        if standing in before:  # what was added does not stand
            break
        before.add(standing)
    state = system(pool, noises)
    return Found(_with_rivals(state, candidates, chosen), noises, p_value, state)


def first_noises(pool: Pool) -> tuple[Noise, ...]:
    """The noise of what the standard's model alone leaves."""
    return noises_of(pool, (), noises_of(pool, (), None))


def beside(pool: Pool, chosen: Sequence[Candidate], noises: Sequence[Noise]) -> tuple[Noise, ...]:
    """The noise of what the chosen leave, fitted by earlier noises."""
    return noises_of(pool, members_of(chosen), noises)


def _put_right(
    state: System, candidates: Sequence[Candidate], chosen: list[Candidate]
) -> list[Candidate]:
    """Takes out what the others have made needless, and exchanges what another does better."""
    for _ in range(3):
        before = list(chosen)
        for one in before:
            if one.key not in {other.key for other in chosen}:
                continue
            rest = [other for other in chosen if other.key != one.key]
            ranked = rank(state, candidates, rest)
            if not ranked or ranked[0].score <= 0:
                chosen = rest
                continue
            own = next((s for s in ranked if s.candidate.key == one.key), None)
            if own is None:
                chosen = rest
            elif ranked[0].score > own.score + 1e-9:
                chosen = [
                    ranked[0].candidate if other.key == one.key else other for other in chosen
                ]
        if [one.key for one in chosen] == [one.key for one in before]:
            break
    return chosen


def _with_rivals(
    state: System, candidates: Sequence[Candidate], chosen: Sequence[Candidate]
) -> tuple[Chosen, ...]:
    found = []
    for one in chosen:
        rest = [other for other in chosen if other.key != one.key]
        ranked = rank(state, candidates, rest)
        own = next((s for s in ranked if s.candidate.key == one.key), None)
        if own is None:
            continue
        rivals: dict[str, Scored] = {}
        for other in ranked:
            if other.candidate.name not in (one.name, *rivals):
                rivals[other.candidate.name] = other
        found.append(Chosen(one, own.gain, own.score, tuple(list(rivals.values())[:6])))
    return tuple(sorted(found, key=lambda each: -each.gain))
