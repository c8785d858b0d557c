# Everything happens in .venv; `make setup` is made by the targets that need it.
PYTHON ?= python3
BIN := .venv/bin
LOCK := --universal --python-version 3.11 --generate-hashes --no-header --no-annotate --quiet
SETUP := .venv/.done
INSTALLED := .venv/.installed

.PHONY: setup install demo test bench validate prove rehearsal factory lock licences clean

setup: $(SETUP)

$(SETUP): requirements-dev.txt pyproject.toml
	@PYTHON=$(PYTHON) bash deploy/setup.sh requirements-dev.txt
	@touch $(INSTALLED) $@

# The program alone, without what tests and proof need besides.
install: $(INSTALLED)

$(INSTALLED): requirements.txt pyproject.toml
	@PYTHON=$(PYTHON) bash deploy/setup.sh requirements.txt
	@touch $@

demo: install
	@$(BIN)/mimucal demo

test: setup
	@bash deploy/test.sh

bench: setup
	@$(BIN)/python -m tests.bench

# Show by 2,000 simulated units and by other programs that what is stated holds.
validate: setup
	@$(BIN)/mimucal validate

# A study of the proof: make prove ARGS="trial --seed 2026"; without ARGS, which there are.
prove: setup
	@$(BIN)/python -m tests.proof $(ARGS)

# What `make prove` does, in small, and other tests that take longer than `make test` may.
rehearsal: setup
	@OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n 2 -m rehearsal tests

# A whole line on this machine: make factory ARGS="--units 100 --out factory.md".
factory: setup
	@$(BIN)/python -m tests.proof factory $(ARGS)

# Pin again, after a change of the dependencies in pyproject.toml (needs uv).
lock:
	uv pip compile pyproject.toml --group dev $(LOCK) --output-file requirements-dev.txt
	uv pip compile pyproject.toml --constraint requirements-dev.txt $(LOCK) --output-file requirements.txt

# The packages' licences and the bill of materials, from what is installed.
licences: setup
	@$(BIN)/python deploy/licences.py

clean:
	rm -rf .venv *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
