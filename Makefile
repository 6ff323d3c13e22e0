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
	$(BIN)/swarmvision bench --out out/bench

venv: $(READY)

# The project in editable form and everything that development needs, pinned and hash-checked.
# OpenCV 4 stands beside it in a folder of its own, for the test that holds the two major versions together.
$(READY): requirements-dev.txt requirements-opencv4.txt pyproject.toml | system
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r requirements-dev.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --require-hashes --upgrade \
		--target $(VENV)/opencv4 -r requirements-opencv4.txt
	touch $@

# What pyrender needs from the distribution. The default renderer needs none of it.
system:
	@sh tools/graphics.sh

clean:
	rm -rf $(VENV) build dist *.egg-info out .pytest_cache .mypy_cache .ruff_cache
