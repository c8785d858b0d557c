"""The stages as plain functions, under the names that their Prefect tasks have in `as_tasks`."""

from tasks.stages.adopt import adopt_terms
from tasks.stages.certify import certify as publish
from tasks.stages.estimate import estimate as estimate_items
from tasks.stages.explain import explain_run
from tasks.stages.record import acquire_run, take_in
from tasks.stages.simulate import simulate_run

__all__ = [
    "acquire_run",
    "adopt_terms",
    "estimate_items",
    "explain_run",
    "publish",
    "simulate_run",
    "take_in",
]
