"""How an effect that runs have in common changes the elements of a certificate."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from schemas.discrepancy import Consequence
from schemas.equipment import EquipmentLimit, LimitName
from schemas.recording import ANGLE, Recording
from schemas.review import ReviewFinding, Touched
from tasks.explain.channels import CHANNELS
from tasks.explain.correction.adopt import corrected
from tasks.explain.correction.consequences import by_clauses, moved
from tasks.explain.inputs.prepared import without_faults
from tasks.explain.report.names import element_title, sentence
from tasks.explain.report.statements import sentences
from tasks.explain.search.candidates import columns_of
from tasks.model.catalogue import catalogue
from tasks.motion.whole import Motion
from tasks.readings.codes import codes_put_right
from tasks.readings.offset_binary import offset_taken_off
from tasks.review.hypotheses import Effect, identity
from tasks.review.run_statistics import layout_of
from tasks.words import message, statement
from tasks.words.quantities import multiple


def moved_elements(
    recording: Recording, effect: Effect, values: np.ndarray,
    limits: Mapping[LimitName, EquipmentLimit] | None = None,
) -> list[Consequence]:  # fmt: skip
    """The elements of a recording's items that an effect of values (m,) SI moves by more than
    0.05 U, as read and less the effect; none where its clauses go by angles. limits: of the
    equipment, as of `calibrate`.

    Raises Unusable where the clauses give no items.
    """
    if all(name in recording.imu.columns for name in ANGLE):
        return []
    recording = offset_taken_off(recording)
    _, _, full = without_faults(recording, codes_put_right(recording))
    added = contribution(recording, full.motion, effect, values)
    before = by_clauses(recording, limits)
    after = by_clauses(corrected(recording, [added]), limits)
    return [each for each in moved(before, after) if each.in_U]


def contribution(
    recording: Recording, motion: Motion, effect: Effect, values: np.ndarray
) -> np.ndarray:
    """(n, 6) rad/s and m/s² that an effect of values (m,) SI adds to the readings."""
    added = np.zeros((len(motion.t), len(CHANNELS)))
    for term in catalogue(recording, motion):
        if term.name != effect.name or term.at != effect.term.at:
            continue
        columns = columns_of(term, motion)
        if identity(layout_of([term], [columns]).terms[0]) != identity(effect.term):
            continue
        for q, value in zip(effect.own, values, strict=True):
            for channel, column in columns[q].items():
                added[:, channel] += value * np.nan_to_num(column)
        return added
    return added


def touched_of(certificate: str, elements: Sequence[Consequence]) -> Iterator[Touched]:
    """The elements as elements of a certificate, in its U."""
    for each in elements:
        yield Touched(certificate=certificate, item=each.item, element=each.element, in_U=each.in_U)


def with_touched(finding: ReviewFinding, touched: Sequence[Touched], looked: int) -> ReviewFinding:
    """The finding with what it moves, the most first, and says so; looked: at so many
    certificates.
    """
    ordered = tuple(sorted(touched, key=lambda each: -abs(each.in_U)))
    if not looked:
        return finding
    words = message("review-touches-none", looked=looked)
    if ordered:
        most = ordered[0]
        words = message(
            "review-touches", count=len({each.certificate for each in ordered}), looked=looked,
            certificate=most.certificate, times=multiple(most.in_U),
            element=element_title(most.item, most.element),
        )  # fmt: skip
    statement_ = statement(sentences([finding.statement, sentence(words)]))
    return finding.model_copy(update={"touched": ordered, "statement": statement_})
