# Everything happens in .venv; `make setup` is made by every other target first.
PYTHON ?= python3
BIN := .venv/bin
SETUP := .venv/.done

.PHONY: setup demo test bench validate prove rehearsal factory lock clean

setup: $(SETUP)

$(SETUP): requirements.txt pyproject.toml
	@PYTHON=$(PYTHON) bash deploy/setup.sh
	@touch $@

demo: setup
	@$(BIN)/mimucal demo

test: setup
	@bash deploy/test.sh

bench: setup
	@$(BIN)/python -m tests.bench

# Show by 2,000 simulated units and by other programs that what is stated holds.
validate: setup
	@$(BIN)/mimucal validate

# Hold the sealed trial: make prove ARGS="--seed 2026 --real ../shared/data/real".
prove: setup
	@$(BIN)/python -m tests.proof $(ARGS)

# What `make prove` does, in small, and other tests that take longer than `make test` may.
rehearsal: setup
	@OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n 2 -m rehearsal tests

# A whole line on this machine: make factory ARGS="--units 100 --out factory.md".
factory: setup
	@$(BIN)/python -m tests.proof.factory $(ARGS)

# Pin again, after a change of the dependencies in pyproject.toml (needs uv).
lock:
	uv pip compile pyproject.toml --group dev --group proof --universal --python-version 3.11 \
	  --generate-hashes --no-header --no-annotate --quiet --output-file requirements.txt

clean:
	rm -rf .venv *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
