# make run : set up .venv with what a run needs and reproduce the papers' figures and claims into report/
# make test: set up .venv with everything and run every check and test
# make test-quick: a minute of tests near the files that changed since main
# make docs: set up .venv and build the site into build/site
# make setup: .venv with what a run needs; make develop: with everything
# make validate: against outside engines; make mutants: wrong versions of the runtime; both need the package index
# make soak: the long campaigns, hours; make matrix: other Pythons and libraries, make sceptic: the claims of speed, minutes;
# make peers: the tools that models are exported to; make compare: one task in other tools; all need the package index
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# bytecode apart from the tree, also where a container asks for none: each of hundreds of processes would compile its libraries
export PYTHONDONTWRITEBYTECODE :=
export PYTHONPYCACHEPREFIX := $(CURDIR)/$(VENV)/bytecode

CAMPAIGNS := validate mutants soak matrix peers compare sceptic

.PHONY: run test suite test-quick docs lint setup develop clean $(CAMPAIGNS) $(CAMPAIGNS:%=campaign-%)
run: setup
	$(BIN)/mehvar reproduce --out report

# the linters beside the tests: a type checker that begins anew has half a minute of one processor
test: develop
	+$(MAKE) --no-print-directory --jobs 2 lint suite

suite: develop
	$(BIN)/mehvar generate --check
	$(BIN)/pytest -n auto --dist loadscope

test-quick: develop
	$(BIN)/python -m tests.quick

docs: develop
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "build/site/index.html"

# what runs outside the suite, and where docs/reference/campaigns.md says what came of it
$(CAMPAIGNS): develop
	$(BIN)/python -m tests.campaigns $@ $(MAKE) --no-print-directory campaign-$@

campaign-soak:
	$(BIN)/pytest -m soak
	$(BIN)/mehvar reproduce --out build/report
	$(BIN)/python -m tests.fuzz commands 1 100000 build/fuzz.jsonl
	$(BIN)/python -m tests.fuzz edits 1 10000 build/fuzz.jsonl
	$(BIN)/python -m tests.fuzz sanitizers 1 300 build/fuzz.jsonl
	$(BIN)/python -m tests.models.structures build/structures.jsonl
	$(BIN)/python -m tests.runtime.board.everywhere 600
	$(BIN)/python -m benchmarks.board fuzz residual guided
	$(BIN)/python -m benchmarks.board day
	$(BIN)/python -m benchmarks.batch.kill_test --kills 200
	$(BIN)/python -m benchmarks.batch.store
	$(BIN)/python -m benchmarks.mutation
	$(BIN)/python -m tests.runtime.run.user.interrupts 10000
	rm -rf report/soak.zarr && mkdir -p report
	$(BIN)/mehvar batch triangle --controller path -n 10000000 --vary "theta_0=uniform(0.8, 1.2)" --out report/soak.zarr

campaign-matrix:
	$(BIN)/python tests/gates/matrix.py

# without constraints.txt: Basilisk asks for versions of its own
campaign-validate:
	$(PYTHON) -m venv .venv-validation
	.venv-validation/bin/python -m pip install --quiet --disable-pip-version-check -e ".[validation]"
	.venv-validation/bin/python -m tests.validation

campaign-mutants:
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[mutants]"
	$(BIN)/python -m tests.mutants $(if $(MINUTES),--minutes $(MINUTES))

campaign-peers:
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[control,jax,numba]" fmpy polars spiceypy twine
	$(BIN)/pytest -m peers

# without constraints.txt, as `validate`
campaign-compare:
	$(PYTHON) -m venv .venv-compare
	.venv-compare/bin/python -m pip install --quiet --disable-pip-version-check -e . -r benchmarks/peers/lqr/requirements.txt
	.venv-compare/bin/python -m benchmarks.compare
	.venv-compare/bin/python -m benchmarks.craft

campaign-sceptic:
	$(PYTHON) -m venv .venv-sceptic
	.venv-sceptic/bin/python -m pip install --quiet --disable-pip-version-check -c benchmarks/peers/requirements.txt -e . heyoka
	.venv-sceptic/bin/python -m benchmarks.sceptic

lint: develop
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

setup: $(VENV)/run
develop: $(VENV)/installed

# without bytecode: Python compiles the few modules that it imports, and pip would compile all before the first
$(VENV)/run: EXTRAS := board,plot
$(VENV)/installed: EXTRAS := dev
# the tests and what they import, which else each process of the first run would compile for itself; types of libraries
LIBRARIES := $(VENV)/libraries.py
$(VENV)/installed: WARM := -c "from tests import commands; commands.load()" && $(BIN)/pytest --collect-only > /dev/null \
	&& $(BIN)/python -c "from tests.commands import *; print('import', ', '.join(LIBRARIES))" > $(LIBRARIES) \
	&& $(BIN)/mypy $(LIBRARIES)
$(VENV)/run $(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --no-compile --disable-pip-version-check -c constraints.txt -e ".[$(EXTRAS)]"
	$(if $(WARM),$(BIN)/python $(WARM))
	@touch $(VENV)/run $@

clean:
	rm -rf $(VENV) .venv-validation .venv-compare .venv-sceptic report
