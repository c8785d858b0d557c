#!/usr/bin/env bash
# Builds .venv from pinned, hashed requirements: those of the file that is named, requirements.txt
# (the program) or requirements-dev.txt (tests and proof, too). They are complete: with --no-deps
# pip asks for nothing newer (an extra of a package that has a new release would break the hashes).
# Installs venv where Debian lacks it, as root.
set -euo pipefail
python=${PYTHON:-python3}
requirements=${1:-requirements.txt}

leave() { echo "$1" >&2; exit 1; }

"$python" -c 'import sys; raise SystemExit(sys.version_info < (3, 11))' 2>/dev/null \
    || leave "mimucal needs Python 3.11 or newer, which $python is not; PYTHON=python3.12 make setup names another"

install_venv() {
    local package=python3-venv
    [[ $(basename "$python") =~ ^python3\.[0-9]+$ ]] && package=$(basename "$python")-venv
    local as_root=()
    if [ "$(id -u)" != 0 ]; then
        sudo -n true 2>/dev/null \
            || leave "$python cannot make a venv; install the package $package as root, then run make setup again"
        as_root=(sudo)
    fi
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" apt-get install -y -qq "$package"
}

"$python" -c 'import ensurepip, venv' 2>/dev/null || install_venv
.venv/bin/python -m pip --version >/dev/null 2>&1 || "$python" -m venv --clear .venv
.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r "$requirements"
.venv/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
.venv/bin/python -m compileall -q .venv/lib >/dev/null 2>&1 || true
