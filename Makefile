# EMA twin: one entry for everything. `make` lists the targets.

PYTHON ?= python3
RUN = .venv/bin/python

# Variables of another ROS installation or virtual environment would mix their libraries into ours.
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH \
	PYTHONHOME PYTHONPATH RMW_IMPLEMENTATION ROS_DISTRO VIRTUAL_ENV

.DEFAULT_GOAL := help
.PHONY: help setup demo test test-all check-types quick-tests all-tests test-pictures docs bench kill fuzz soak mutants vulnerabilities accuracy wear figures pictures blueprints lock clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST)

setup: ## ROS 2, all libraries and the packages into .venv; does only what changed
	@$(PYTHON) bootstrap.py $(if $(filter setup,$(MAKECMDGOALS)),--next)

demo: setup ## a recorded actuator beside its twin; then the missing effects are added
	@.venv/bin/ema-twin demo

STYLE = $(RUN) -m ruff check .
# Types are checked beside the tests: alone, they would leave all cores but one idle.
BESIDE_TYPES = $(MAKE) --no-print-directory -j2 check-types
# Containers often set PYTHONDONTWRITEBYTECODE; every test process would read all tests anew, for six seconds each.
TESTS = PYTHONDONTWRITEBYTECODE= $(RUN) -m pytest tests -n auto --dist loadfile --no-loadscope-reorder

test: setup ## style and type checks, and every test but those that take long
	@$(STYLE)
	+@$(BESIDE_TYPES) quick-tests

test-all: setup ## the same, and the tests that take long; nineteen cases of make accuracy among them
	@$(STYLE)
	+@$(BESIDE_TYPES) all-tests

check-types:
	@$(RUN) -m mypy

quick-tests:
	@$(TESTS) -m "not slow"

all-tests:
	@$(TESTS)

test-pictures: setup ## the report and the live view in a browser, the views in rerun; needs chromium and mesa-vulkan-drivers
	@.ci/drawing_tools
	@$(RUN) -m pytest tests/report/test_report_in_browser.py tests/report/test_fleet_in_browser.py tests/views/test_web_viewer.py tests/views/test_views_in_rerun.py

docs: setup ## the tutorials and the reference as HTML in docs/_build; needs no network
	@$(RUN) -m sphinx --fail-on-warning --keep-going --quiet docs docs/_build
	@echo "docs/_build/index.html: open it in any browser"

bench: setup ## the benchmarks
	@$(RUN) -m pytest tests/benchmarks/bench_*.py -q

kill: setup ## nodes are killed beside a bench that plays: how long it halts, when they work again; ARGS="--kills 10 --orders 24", "--help"
	@$(RUN) -m tests.kill_nodes $(ARGS)

fuzz: setup ## random files and messages for all that reads them: none may break a promise; ARGS="--inputs 1000000", "--guided", "--help"
	@$(RUN) -m tests.fuzz.run $(ARGS)

soak: setup ## the four nodes at 1 kHz for a long time: memory, samples lost, the twin's time; ARGS="--minutes 60"
	@$(RUN) -m tests.soak $(ARGS)

mutants: setup ## faults in the criteria and the pairing, one at a time: what no test notices; ARGS="--sample 200", "--files worth"
	@$(RUN) -m tests.mutants $(ARGS)

vulnerabilities: ## which locked libraries have known vulnerabilities; asks the package index, so it needs a network
	@$(PYTHON) -m venv --clear .venv-audit && .venv-audit/bin/python -m pip install --quiet pip-audit || \
		{ echo "could not be asked: pip-audit could not be installed"; rm -rf .venv-audit; exit 2; }
	@.venv-audit/bin/python tests/vulnerabilities.py .venv-audit/bin/pip-audit; status=$$?; rm -rf .venv-audit; exit $$status

accuracy: setup ## how well missing effects are named on another bench; ARGS="--known", "--sweep", "--other-machines 60", "--calibration", "--contradictions 200", "--help"
	@$(RUN) -m tests.accuracy.run $(ARGS)

wear: setup ## fleets that run to failure: how early wear is named, false alarms, what is left; ARGS="--seed 3", "--simulated 20"
	@$(RUN) -m tests.run_to_failure.run $(ARGS)

figures: setup ## the figures and numbers of docs/physics.md; ARGS="--speed" measures what a step costs too
	@$(RUN) -m docs.figures $(ARGS)

pictures: setup ## the pictures of rerun's views in docs/pictures; needs mesa-vulkan-drivers
	@$(RUN) -m docs.pictures

blueprints: setup ## the layouts for rerun in config/blueprints
	@$(RUN) -m ema_twin_sim.views.bag_blueprint config/blueprints

lock: ## refresh requirements.lock
	@$(PYTHON) -m venv --clear .venv-lock && .venv-lock/bin/python -m pip install --quiet uv
	@.venv-lock/bin/uv pip compile --quiet --universal --upgrade --no-annotate --python-version 3.10 \
		--custom-compile-command "make lock" --output-file requirements.lock \
		requirements.txt requirements-dev.txt requirements-ros.txt
	@rm -rf .venv-lock

clean: ## remove .venv
	rm -rf .venv .venv-lock .venv-audit
