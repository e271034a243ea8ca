# Two commands: `make demo` and `make test`. Both install into .venv whatever is missing there.
PYTHON ?= python3
BIN := .venv/bin
# One process per core, but at most 4. Each loads what the others have compiled.
PYTEST := $(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal

.PHONY: demo test test-all pytest docs report report-quick lint lock clean

demo: .venv/demo.done
	$(BIN)/izo demo

# The check of types takes half a minute on one core, so it runs beside the tests.
test: .venv/dev.done
	$(MAKE) --jobs=2 lint pytest

test-all: .venv/dev.done
	$(MAKE) --jobs=2 lint pytest SLOW=--slow

pytest: .venv/dev.done
	$(PYTEST) $(SLOW)

# The pages of the documentation: docs/_build/html/index.html
docs: .venv/dev.done
	$(BIN)/python -m sphinx -E -W --keep-going -n -q -b html -d docs/_build/trees docs docs/_build/html

# Error against time: reports/index.html; rows that exist are kept.
report: .venv/dev.done
	$(BIN)/python -m validation report

# A few cells of each study, which show that it works: reports/quick/index.html, in 3 minutes.
report-quick: .venv/dev.done
	$(BIN)/python -m validation report --quick

lint: .venv/dev.done
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/basedpyright --pythonpath $(BIN)/python

.venv/pip.done:
	$(PYTHON) -c 'import sys; assert sys.version_info >= (3, 11), "Python >= 3.11 is needed"'
	$(PYTHON) -m venv .venv
	touch $@

.venv/demo.done: .venv/pip.done requirements/demo.txt pyproject.toml
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --require-hashes -r requirements/demo.txt
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

.venv/dev.done: .venv/pip.done requirements/dev.txt pyproject.toml
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --require-hashes -r requirements/dev.txt
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

# Needs uv. Versions and hashes for every platform, no addresses.
lock:
	uv pip compile --quiet --universal --generate-hashes --no-header --no-annotate --python-version 3.11 --extra dev pyproject.toml requirements/build.in -o requirements/dev.txt
	uv pip compile --quiet --universal --generate-hashes --no-header --no-annotate --python-version 3.11 --extra demo pyproject.toml requirements/build.in -c requirements/dev.txt -o requirements/demo.txt

clean:
	rm -rf .venv build *.egg-info
