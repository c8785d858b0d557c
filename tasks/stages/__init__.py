"""The stages of the line: acquire, import, estimate, certify, explain, simulate, remind.

A stage is a plain function; `stage.py` makes it a task of the Prefect flow that calls it.
Nothing below knows Prefect.
"""
