"""The stages of the line: acquire, take in, estimate, certify, remind.

A stage is a plain function; `as_tasks` holds the Prefect task of each. Nothing below knows
Prefect.
"""
