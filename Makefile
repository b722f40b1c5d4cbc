# make run : set up .venv and reproduce the papers' figures and claims into report/
# make test: set up .venv and run every check and test
# make docs: set up .venv and build the site into build/site
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: run test docs lint setup clean
run: setup
	$(BIN)/mehvar reproduce --out report

test: setup lint
	$(BIN)/mehvar generate --check
	$(BIN)/pytest -n auto --dist loadscope

docs: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "build/site/index.html"

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

setup: $(VENV)/installed

$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e ".[dev]"
	@touch $@

clean:
	rm -rf $(VENV) report
