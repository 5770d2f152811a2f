# `make run` and `make test` set up everything they need; a second call sets up nothing and needs no network.
VENV := .venv
PYTHON_IN_VENV := $(VENV)/bin/python
PIP := $(PYTHON_IN_VENV) -m pip --disable-pip-version-check --quiet
READY_RUN := $(VENV)/.ready-run
READY_TEST := $(VENV)/.ready-test
ARGS ?=

# one BLAS thread for each worker: two were measured 40 times slower under load
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.DEFAULT_GOAL := help
.PHONY: help setup run test lint lock clean

help:  ## show this list
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 10

setup: $(READY_RUN)  ## virtual environment, locked packages, system libraries

run: $(READY_RUN)  ## the main job; pass options as ARGS="--study dlr"
	$(PYTHON_IN_VENV) -m bench run $(ARGS)

test: lint  ## lint, then all tests
	$(ONE_THREAD) $(PYTHON_IN_VENV) -m pytest -q -n 2 --dist loadfile

lint: $(READY_TEST)  ## style, format, import contracts, types
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/lint-imports --no-logo
	$(VENV)/bin/mypy

lock: $(READY_TEST)  ## resolve the lock files anew (needs the network)
	$(PYTHON_IN_VENV) tools/lock.py

clean:  ## remove the virtual environment and all caches
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(VENV)/.created:
	sh tools/setup.sh venv $(VENV)
	@touch $@

$(READY_RUN): $(VENV)/.created requirements-run.lock pyproject.toml
	@echo "installing the locked packages (once, some minutes)"
	$(PIP) install --require-hashes -r requirements-run.lock
	$(PIP) install --no-deps --no-build-isolation --editable .
	sh tools/setup.sh libraries $(VENV)
	@echo "compiling the kernels (once)"
	$(PYTHON_IN_VENV) -m bench.warm_up
	@touch $@

$(READY_TEST): $(READY_RUN) requirements-dev.lock
	$(PIP) install --require-hashes -r requirements-dev.lock
	@touch $@
