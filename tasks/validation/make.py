"""Makes the validation record: all evidence for every item of every method."""

import time
from collections.abc import Callable
from datetime import date

from schemas.validation import Check, Evidence, ItemValidation, MethodValidation, ValidationRecord
from tasks.validation.coverage import Calibrate, coverage_check, recovery_checks, study
from tasks.validation.examples import example_check
from tasks.validation.fingerprint import fingerprint, names_of, text_digest
from tasks.validation.independent import independent_checks
from tasks.validation.record import clause_item
from tasks.validation.scenarios import study_scenarios

FEWER = 10  # times fewer units in each scenario than in order


def make_record(
    methods: dict[str, Calibrate],
    units: int,
    seed: int,
    code_version: str,
    report: Callable[[int, int], None],
) -> ValidationRecord:
    """All evidence for every item of the methods; the coverage over as many simulated units.

    Raises Unusable where GTC is not installed.
    """
    began = time.monotonic()
    independent = {m: independent_checks(m, calibrate, seed) for m, calibrate in methods.items()}
    recovered = {m: recovery_checks(m, calibrate, seed) for m, calibrate in methods.items()}
    methods_made = {}
    for method, coverages in study(methods, units, seed, report).items():
        items = {}
        for name, coverage in coverages.items():
            item = clause_item(name)
            checks: dict[Evidence, Check] = {
                "worked example": example_check(item),
                "coverage": coverage_check(coverage),
            }
            if name in recovered[method]:
                checks["truth recovery"] = recovered[method][name]
            if item in independent[method]:
                checks["independent program"] = independent[method][item]
            items[name] = ItemValidation(checks=checks, coverage=coverage)
        names = names_of(method)
        methods_made[method] = MethodValidation(
            fingerprint=fingerprint(method), sources=names, text=text_digest(names), items=items
        )
    scenarios = study_scenarios(methods, max(1, units // FEWER), seed, report)
    return ValidationRecord.model_validate(
        {
            "made_on": date.today(),
            "code_version": code_version,
            "seed": seed,
            "seconds": round(time.monotonic() - began, 1),
            "methods": methods_made,
            "scenarios": scenarios,
        }
    )
