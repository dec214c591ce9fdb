# make demo: set up and run the main job.   make test: set up and run the tests.
#
# PYTHON=...  the interpreter to set up with (default: the first on the path that is new enough)
# VENV=...    the folder of the virtual environment
PYTHON ?=
VENV = .venv
BIN = $(VENV)/bin
PYTEST = $(BIN)/python -m pytest -q --numprocesses logical --maxprocesses 4

# What another installation put into the environment (a sourced ROS set-up, for one) must not shadow the pinned packages.
unexport PYTHONPATH
unexport PYTHONHOME

.DEFAULT_GOAL := help
.PHONY: help setup demo test test-slow test-thorough test-all lint bench gallery docs clean

help:
	@echo "make demo      set up, cross-check both robots, reproduce the papers' experiments"
	@echo "make test      set up and run the tests"
	@echo "make test-slow the slow tests, of large families some cases (make test-thorough: the others)"
	@echo "make test-all  all of them"
	@echo "make lint      ruff, mypy --strict, the layers and the house's rules"
	@echo "make bench     benchmarks, with the peers that are installed"
	@echo "make docs      the documents as pages to be opened as files, in out/site; with the gallery where there is one"
	@echo "make gallery   pictures and animations of the robots, in out/gallery"
	@echo "make clean     remove the virtual environment, builds and caches"

setup:
	@tools/setup.sh $(VENV) $(PYTHON)

demo: setup
	@$(BIN)/cutjoint crosscheck all
	@mkdir -p out
	@$(BIN)/cutjoint reproduce all --output out/reproduction.html
	@printf '\nWhere to go next\n'
	@printf '  %-53s  %s\n' \
	  'out/reproduction.html' 'the report with all figures, for a browser' \
	  '$(BIN)/cutjoint list' 'all robots by name' \
	  '$(BIN)/cutjoint info stewart' 'what a robot is and how it can move' \
	  '$(BIN)/cutjoint view omega3' 'a robot in the browser, moved by hand' \
	  '$(BIN)/cutjoint simulate omega3 --save out/run.npz' 'a controller leads it along a curve' \
	  '$(BIN)/cutjoint play out/run.npz' 'that simulation in the browser' \
	  '$(BIN)/cutjoint plot out/run.npz' 'its curves as a picture, out/run.svg' \
	  '$(BIN)/cutjoint report out/run.npz' 'all about it as a page, out/run.html' \
	  '$(BIN)/cutjoint workspace omega3 -o out/space.png' 'where its tool can be, as a picture' \
	  '$(BIN)/cutjoint size omega3 --bearings' 'what its motors and bearings must give' \
	  '$(BIN)/cutjoint new my_robot -o out/my_robot' 'a robot of your own, from a template' \
	  '. $(BIN)/activate' 'puts cutjoint on the path of this shell' \
	  '$(BIN)/cutjoint --install-completion' 'the Tab key completes commands and robots'

test: setup
	@$(PYTEST) -m "not slow"

test-slow: setup
	@$(PYTEST) -m "slow and not thorough"

test-thorough: setup
	@$(PYTEST) -m thorough

test-all: setup
	@$(PYTEST)

lint: setup
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/python tools/layers.py
	@$(BIN)/python tools/house.py

bench: setup
	@$(BIN)/python tools/bench.py

gallery: setup
	@$(BIN)/python tools/gallery.py

docs: setup
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict
	@echo "out/site/index.html"

clean:
	rm -rf $(VENV) build dist out .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find src tests tools -name __pycache__ -type d -prune -exec rm -rf {} +
