# make demo: set up and run the main job.   make test: set up and pass every test.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.ready

.PHONY: demo test test-all lint setup clean bench
.DEFAULT_GOAL := help

help:
	@echo "make demo   set up, cross-check both robots and reproduce the papers' experiments"
	@echo "make test   set up and run the tests"
	@echo "make lint   ruff, mypy --strict and the layer check"
	@echo "make clean  remove the virtual environment and all caches"

setup: $(STAMP)

$(STAMP): pyproject.toml constraints.txt
	@echo "setting up $(VENV) (once, about two minutes)"
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "cutjoint needs Python 3.11 or newer; found %s. Try: make PYTHON=python3.12" % sys.version.split()[0])'
	@$(PYTHON) -m venv $(VENV)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $(STAMP)

demo: $(STAMP)
	@$(BIN)/cutjoint crosscheck

test: $(STAMP)
	@$(BIN)/python -m pytest -q -m "not slow"

test-all: $(STAMP)
	@$(BIN)/python -m pytest -q

lint: $(STAMP)
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/python tools/layers.py

clean:
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache
