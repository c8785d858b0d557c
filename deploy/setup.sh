#!/usr/bin/env bash
# Builds .venv from the pinned, hashed requirements. Installs python3-venv where Debian lacks it.
set -euo pipefail
python=${PYTHON:-python3}

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

"$python" - <<'CHECK' || { echo "mimucal needs Python 3.11 or newer; PYTHON=… make setup names another" >&2; exit 1; }
import sys
raise SystemExit(sys.version_info < (3, 11))
CHECK

if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    as_root apt-get update -qq
    as_root apt-get install -y -qq python3-venv
fi
[ -x .venv/bin/python ] || "$python" -m venv .venv
.venv/bin/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.txt
.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
.venv/bin/python -m compileall -q .venv/lib >/dev/null 2>&1 || true
