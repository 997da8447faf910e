# The environment is .venv; everything made goes to build/.
PYTHON ?= python3
BIN := .venv/bin
ENV := .venv/.installed
# Every process would compile all modules and rewrite all tests anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: design compare test suite campaigns bounds fuzz mutants bench lint notebooks docs env clean

design: $(ENV)
	$(BIN)/wrist design plants/measured/examples/flexion plants/measured/examples/deviation --out build/design

# Of the plants and gains of the design, which is quick where it is made already.
compare: design
	$(BIN)/wrist compare --design build/design --samples 0 --mpc-plants 0 --out build/compare

test: $(ENV)
	$(BIN)/python -m pytest -n 2 --durations=10

# With BUDGET=SECONDS, tests that have not begun by then are skipped.
suite: $(ENV)
	$(BIN)/python -m pytest -n 2 -m 'suite or slow' --durations=20 $(if $(BUDGET),--budget $(BUDGET) -rs)

# All campaigns of the trace's suite, of which `make suite` takes every third.
campaigns: $(ENV)
	WRIST_CAMPAIGNS=all $(BIN)/python -m pytest -n 1 -m suite tests/trace/test_suite.py

# Compiled kernels with every index checked: what is written past an end is silent without.
bounds: $(ENV)
	NUMBA_BOUNDSCHECK=1 $(BIN)/python -m pytest -n 2 -m 'not suite' tests/kernel tests/laws tests/control/test_mpc_*.py tests/control/test_spikes.py

TRIES ?= 5000
SEED ?= 0
fuzz: $(ENV)
	$(BIN)/python -m tests.fuzz --tries $(TRIES) --seed $(SEED)

COUNT ?= 20
mutants: $(ENV)
	$(BIN)/python -m tests.mutants --count $(COUNT) --seed $(SEED)

bench: $(ENV) .venv/.bench
	$(BIN)/python -m benchmarks

lint: $(ENV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest --collect-only -qq -m '' >/dev/null # each test module can be imported

notebooks: $(ENV)
	$(BIN)/python notebooks/build.py

docs: $(ENV)
	$(BIN)/python -m docs.build

env: $(ENV)

$(ENV): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "make: Python 3.11 or newer is needed; set PYTHON=python3.x"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || { echo "make: no venv; install it first: apt-get install python3-venv"; rm -rf .venv; exit 1; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

.venv/.bench: $(ENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	@touch $@

clean:
	rm -rf build
