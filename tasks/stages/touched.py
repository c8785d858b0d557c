"""Which certificates print values that an effect common to many runs changes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.base import Unusable
from schemas.certificate import LIVE
from schemas.review import Review, Touched
from storage.catalogue import certificates, runs
from storage.catalogue.run_index import Run
from storage.home import Home
from tasks.review.hypotheses import Effect
from tasks.review.search import Found
from tasks.review.touched import moved_elements, touched_of, with_touched
from tasks.review.windows import rows_of
from tasks.stages.fan_out import fan_out, processors

MOST = 200  # certificates of a finding that are looked at, the newest
WORTH_A_PROCESS = 8  # certificates that take longer than a process takes to begin


@dataclass(frozen=True)
class AffectedCertificate:
    """A certificate, the run it is based on, and an effect with values (m,) SI."""

    certificate: str
    run: Run
    effect: Effect
    values: np.ndarray
    home: Home


def with_certificates(
    review: Review, found: Sequence[Found], chosen: Mapping[str, Run], home: Home
) -> Review:
    """The review with what each finding changes in the certificates based on its runs.

    found: of each finding. chosen: runs by id.
    """
    standing = [each for each in certificates.register(home) if each.state in LIVE]
    findings = []
    for finding, one in zip(review.findings, found, strict=True):
        affected = {
            one.pool.runs[k].run for k in np.flatnonzero(rows_of(one.pool, one.best.window))
        }
        jobs = [
            AffectedCertificate(entry.number, chosen[entry.run], one.best.effect, one.values, home)
            for entry in standing if entry.run in affected
        ][-MOST:]  # fmt: skip
        workers = min(processors(), len(jobs) // WORTH_A_PROCESS)
        elements = [each for some in fan_out(_touched, jobs, workers, _none) for each in some]
        findings.append(with_touched(finding, elements, len(jobs)))
    return review.model_copy(update={"findings": tuple(findings)})


def _touched(job: AffectedCertificate) -> list[Touched]:
    """Nothing where the recording is gone or its clauses give no items."""
    try:
        elements = moved_elements(runs.load(job.run, job.home), job.effect, job.values)
    except Unusable:
        return []
    return list(touched_of(job.certificate, elements))


def _none(job: AffectedCertificate) -> list[Touched]:
    return []
