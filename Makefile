# Two commands matter to a newcomer: `make demo` and `make test`. Both make their own environment.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
OUT ?= out/flocking

.PHONY: demo test lint bench venv system clean

demo: venv
	$(BIN)/swarmvision demo --out $(OUT)

test: venv
	$(BIN)/pytest -n 2 --dist loadfile

lint: venv
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: venv
	$(BIN)/pytest benchmarks --benchmark-only -o python_files='bench_*.py' -o python_functions='bench_*'

venv: $(READY)

# The project in editable form and everything that development needs, pinned and hash-checked.
$(READY): requirements-dev.txt pyproject.toml | system
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r requirements-dev.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

# What pyrender needs from the distribution. The default renderer needs none of it.
system:
	@sh tools/graphics.sh

clean:
	rm -rf $(VENV) build dist *.egg-info out .pytest_cache .mypy_cache .ruff_cache
