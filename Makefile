# The whole set-up is `make demo` or `make test`: both make the environment .venv on first use.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

VENV ?= .venv
MISSION ?= missions/explore.yaml
# Of tests at once. One more than there are processors: tests of processes wait most of their time.
PROCESSES ?= $(shell expr $$(nproc) + 1)
FUZZ_ARGS ?= --target all --seconds 24
# The newest of these that works is taken; `make demo PYTHON=python3.12` takes that one.
PYTHONS := $(or $(PYTHON),python3.13 python3.12 python3.11 python3)

# The environment brings its own ROS. A ROS that the calling shell has sourced, or the marks that
# Python leaves in the environment of its children when it starts with other ROS wheels, must not
# get in between.
unexport AMENT_PREFIX_PATH CMAKE_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH PYTHONHOME \
  _ROS_WHEELS_BOOTSTRAP_COMPLETE
# What is imported first is compiled then, once.
unexport PYTHONDONTWRITEBYTECODE

# What a run needs, and what development needs besides. Written last, so that each is newer than what
# it was made from exactly when the set-up went through.
packages := $(VENV)/.packages
runs := $(VENV)/.runs
installed := $(VENV)/.installed
bin := $(VENV)/bin
# Python compiles what is imported, when it is.
install = $(bin)/python -m pip install -qq --disable-pip-version-check --no-compile

.PHONY: help demo installed test thorough fuzz benchmarks lint layers types prose format docs generated doctor clean

help: ## say what can be made
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(runs) ## run the main job: explore.yaml on a simulated TurtleBot3
	@$(bin)/bt-mission run $(MISSION)

installed: $(installed)

test: $(installed) ## run the tests, on all processors
	@$(bin)/pytest --processes=$(PROCESSES) $(PYTEST_ARGS)

thorough: PYTEST_ARGS += --thorough
thorough: test ## run the tests, and those that repeat them on every case or at length

fuzz: $(installed) ## mutate what comes from outside for half a minute, and look for what is not caught
	@$(bin)/python tools/fuzz.py $(FUZZ_ARGS)

benchmarks: $(installed) ## a tiny run of each benchmark and campaign: do they work? For figures: .venv/bin/python -m benchmarks
	@$(bin)/python -m benchmarks all --smoke

lint: $(installed) ## check style and banned calls
	@$(bin)/ruff check
	@$(bin)/ruff format --check

layers: ## print the layers of the packages, cycles and upward imports
	@python3 tools/check_layers.py

types: $(installed) ## check types
	@$(bin)/mypy

prose: ## check the words of pages, docstrings, help and messages; needs npm, which installs textlint below build/ on first use
	@python3 tools/check_prose.py

format: $(installed) ## put the sources in order
	@$(bin)/ruff check --fix
	@$(bin)/ruff format

docs: $(installed) ## build the documentation site, build/site; REFS="v1 main" adds these versions
	@$(bin)/python tools/build_site.py $(REFS)

generated: $(installed) ## write what docs/ takes from the code: the tables of faults, nature, limits and keys, the picture of the packages
	@$(bin)/python tools/make_generated.py

doctor: $(runs) ## say what this machine lacks
	@$(bin)/bt-mission doctor

clean: ## remove the environment and what the tools left behind
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find bt_mission action_servers sim tests -name __pycache__ -type d -prune -exec rm -rf {} +

$(packages): pyproject.toml
	@if ! [ -x $(bin)/python ]; then \
	  python=$$(bash tools/find-python $(PYTHONS)); \
	  echo "Making $(VENV) with $$($$python --version)"; \
	  $$python -m venv $(VENV); \
	fi
	@echo "Installing what a run needs into $(VENV): about a minute, once"
	@$(bin)/python tools/requirements.py run >$(VENV)/requirements.txt
	@$(install) --requirement $(VENV)/requirements.txt
	@touch $@

# An editable install: sources are live, so only its description and the compiled interfaces count. They
# are built with what a run has installed: an environment of its own would be the same again.
$(runs): $(packages) $(shell find interfaces -type f)
	@$(install) --no-build-isolation --no-deps --editable .
	@touch $@

# With --jobs=2, beside the interfaces.
$(VENV)/.tools: $(packages)
	@echo "Installing what development needs into $(VENV): about a minute, once"
	@$(bin)/python tools/requirements.py dev >$(VENV)/requirements-dev.txt
	@$(install) --requirement $(VENV)/requirements-dev.txt
	@touch $@

$(installed): $(runs) $(VENV)/.tools
	@touch $@
