#!/usr/bin/env bash
# What a change must pass: style, types, the arrows between the rooms, the tests.
set -euo pipefail
export DO_NOT_TRACK=1 PREFECT_SERVER_ANALYTICS_ENABLED=false
unset PYTHONDONTWRITEBYTECODE # every worker and every command would compile this code again
export OPENBLAS_NUM_THREADS=1 # three workers share two cores: some tests wait
.venv/bin/ruff check .
.venv/bin/ruff format --check .
# Types and arrows are checked while tests wait; their report stands below that of the tests.
report=$(mktemp)
(.venv/bin/mypy && .venv/bin/lint-imports) > "$report" 2>&1 &
checks=$!
trap 'kill "$checks" 2> /dev/null || true; rm -f "$report"' EXIT
failed=0
.venv/bin/pytest -n 3 --dist loadfile --no-loadscope-reorder "$@" || failed=$?
wait "$checks" || failed=$?
cat "$report"
exit "$failed"
