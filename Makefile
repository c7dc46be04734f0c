# Every target sets itself up in .venv, from nothing but Python >= 3.11. No compiler is needed.
.DEFAULT_GOAL := help

# The first that really starts, is new enough and can make a venv; `make PYTHON=...` chooses another.
USABLE = import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))
PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3; do \
	$$p -c '$(USABLE)' >/dev/null 2>&1 && { echo $$p; break; }; done)

BIN := .venv/bin
READY := .venv/ready
# Where it is set, each of the thousand processes that tests start would compile everything again.
unexport PYTHONDONTWRITEBYTECODE
OUT := demo-out
SOAK_OUT := soak-out
RESULTS := docs/results
SITE := site
SBOM := teletaction/sbom.json
# Files with tests of this mark: pytest need not import the others.
marked = $(sort $(shell grep -rlE --include='test_*.py' 'mark\.$(1)\b' tests))

.PHONY: help
help:
	@echo "make demo        60 s session on simulated devices; leaves summary, report and recording in $(OUT)/"
	@echo "make test        the fast tests"
	@echo "make long        tests that compute longer: sessions on a virtual clock, calibrations, small studies; WITHIN=tests/virtual"
	@echo "make session     tests that run whole sessions in real time"
	@echo "make study-tests  what long studies find (a minute)"
	@echo "make costs       processor time of the link, on a machine that does nothing else"
	@echo "make mutants     small changes to the gates, each with the tests that reach it (hours at first, later only what changed)"
	@echo "make breaks      ten deliberate breaks, each of which the fast tests must notice"
	@echo "make hardening   a million broken frames for each decoder, 500 random sequences of packets for each site (minutes); SEQUENCES=100000"
	@echo "make properties  every property with a thousand examples (minutes)"
	@echo "make netns       the link between two network namespaces that delay and lose packets (root)"
	@echo "make containers  tests that run the composition in containers (needs an engine)"
	@echo "make image       builds the image twice, compares both, and runs the services beside the sites in it (installs an engine)"
	@echo "make console     the console's page in a real Chromium (\$$CHROMIUM, or the system's)"
	@echo "make faults      every fault of the table, on the test bed where that can show it; writes docs/faults.md (FAULTS=real: all in real time)"
	@echo "make everything  all longer tests, in pieces; resumes after an interruption; writes docs/verification.md; PIECES='soak'"
	@echo "make dask        studies on a Dask cluster of two workers, one of which is killed"
	@echo "make exports     exported recordings and live outlets as other tools read them (downloads 500 MB)"
	@echo "make examples    every script and notebook of examples/ (downloads 100 MB); NOTEBOOKS=examples/notebooks keeps their output"
	@echo "make results     every study in full into $(RESULTS)/, with an overview; ARGUMENTS=--quick"
	@echo "make soak        ten minutes of work with faults at random; ARGUMENTS='--seconds 3000 --seed 7'"
	@echo "make pages       every command of README and pages; the demo as installed from the source distribution"
	@echo "make docs        the documentation as a site in $(SITE)/; a broken link is an error"
	@echo "make check       style, types, import contracts, the word list"
	@echo "make coverage    both gates must be covered to 100 % of lines and branches"
	@echo "make picture     docs/session.png from the last demo"
	@echo "make console-picture  docs/console.png from a demo in a real Chromium (two minutes)"
	@echo "make tables      makes the shipped calibration tables again, from simulated sensors"
	@echo "make rungs       makes the table of the errors of the skin models again"
	@echo "make budget      measures on this machine the allowed cost of each stage of a tick (a minute)"
	@echo "make golden      makes the expected output of the golden replay again; ARGUMENTS=--record for its inputs too"
	@echo "make lock        writes constraints.txt and the hashes in locks/ again, without newer versions; ARGUMENTS=--upgrade"
	@echo "make sbom        writes the CycloneDX bill of materials $(SBOM), for wheel and image"
	@echo "make audit       lists known weaknesses of the locked versions (needs a network)"
	@echo "make clean       removes all that these commands made"

# Every file is checked against its hash. A lock is complete: with --no-deps nothing else is looked for.
# Python compiles a module at its first import. Most modules of these packages are never imported.
INSTALL := $(BIN)/pip install --quiet --disable-pip-version-check --prefer-binary --no-compile
LOCKED := $(INSTALL) --no-deps --require-hashes -r

$(READY): pyproject.toml locks/dev.txt locks/installer.txt
	@test -n "$(PYTHON)" || { echo "make: no Python >= 3.11 with venv found; say make PYTHON=/path/to/python3" >&2; exit 2; }
	rm -rf .venv
	$(PYTHON) -m venv .venv
	$(LOCKED) locks/installer.txt
	$(LOCKED) locks/dev.txt
	$(INSTALL) --no-deps --no-build-isolation -e .
	@touch $@

.PHONY: demo
demo: $(READY)
	$(BIN)/teletaction demo --headless --seconds 60 --scene materials --out $(OUT)
	@echo "the report is $(OUT)/report.html"

.PHONY: test
test: $(READY)
	$(BIN)/pytest -n auto --dist worksteal -m 'not (session or long or containers or image or hardening or netns or faults or console or dask or pages or exports or examples or costs or study)' $(addprefix --ignore=,$(WITHOUT))

# WITHIN names folders or files, and only theirs run.
WITHIN := tests
.PHONY: long
long: $(READY)
	$(BIN)/pytest -n auto --dist worksteal --durations=10 -m 'long and not (hardening or exports)' $(filter $(WITHIN) $(addsuffix /%,$(WITHIN)),$(call marked,long))

# Those that load the machine, measure cost, run all five fingers or six processes run alone. The others run two at a time.
MEASURED := tests/system/test_demo.py tests/system/test_keys_live.py tests/system/test_overload.py tests/unit/benchmarks/runtime_cost/test_runtime_cost.py
.PHONY: session
session: $(READY)
	$(BIN)/pytest -m session -n 2 --dist loadfile --durations=10 $(filter-out $(MEASURED),$(call marked,session))
	$(BIN)/pytest -m session --durations=10 $(MEASURED)

.PHONY: study-tests
study-tests: $(READY)
	$(BIN)/pytest -m study -n 2 tests/unit/studies

.PHONY: costs
costs: $(READY)
	$(BIN)/pytest -m costs tests/unit/benchmarks

.PHONY: containers
containers: $(READY)
	@settings=$$(PYTHON=$(PYTHON) tests/network/prepare.sh); eval "$$settings"; $(BIN)/pytest -m containers -rPs --durations=10 tests/containers

# Builds the image twice, and the image for camera and voice.
.PHONY: image
image: $(READY)
	@settings=$$(tests/containers/engine.sh); eval "$$settings"; trap '[ -z "$$ENGINE_PID" ] || kill $$ENGINE_PID' EXIT; \
		$(BIN)/pytest -m image -rPs tests/containers

# Results stay in mutants/: the next run tries what has changed. `mutmut browse` shows each one.
.PHONY: mutants
mutants: $(READY)
	$(LOCKED) locks/mutants.txt
	$(BIN)/mutmut run
	$(BIN)/mutmut results

.PHONY: breaks
breaks: $(READY)
	$(BIN)/python -m tests.breaks

# Sessions at their full rate beside their attackers: a core must not be busy with something else.
ALONE := tests/robustness/hardening/test_hostile_connections.py tests/robustness/hardening/test_console_attacked.py tests/robustness/adversary
.PHONY: hardening
hardening: $(READY)
	$(BIN)/pytest -m hardening -n 2 $(addprefix --ignore=,$(ALONE)) tests/robustness/hardening tests/unit/teletaction tests/virtual
	$(BIN)/pytest -m hardening $(ALONE)

# Every property with twenty times as many examples.
.PHONY: properties
properties: $(READY)
	$(BIN)/pytest -m 'hypothesis and not (hardening or exports)' --hypothesis-profile=search -n 2 tests/unit tests/robustness

.PHONY: netns
netns: $(READY)
	@settings=$$(PYTHON=$(PYTHON) tests/network/prepare.sh); eval "$$settings"; $(BIN)/pytest -m netns -rPs tests/network

.PHONY: faults
faults: $(READY)
	FAULT_PAGE=$(if $(FAULTS),,docs/faults.md) $(BIN)/pytest -m faults -rP tests/robustness/faults/test_fault_matrix.py

# SCREENSHOTS=folder keeps a picture of every state. What is in real time needs the machine to itself.
TIMED := tests/browser/test_connection.py $(wildcard tests/browser/test_live_*.py)
.PHONY: console
console: $(READY)
	$(LOCKED) locks/browser.txt
	$(BIN)/pytest -m console -rs -n 2 tests/browser $(addprefix --ignore=,$(TIMED))
	$(BIN)/pytest -m console -rs $(TIMED)

.PHONY: soak
soak: $(READY)
	$(BIN)/python -m robustness.soak --out $(SOAK_OUT) $(ARGUMENTS)

.PHONY: check
check: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m tests.docs.words

.PHONY: pages
pages: $(READY)
	$(BIN)/pytest -m pages tests/docs/test_hardware_page.py
	$(BIN)/pytest -m pages -n 2 --ignore=tests/docs/test_hardware_page.py tests/docs tests/packaging

# Warnings are errors, also those about links that lead nowhere.
.PHONY: docs
docs: $(READY)
	$(LOCKED) locks/docs.txt
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going --nitpicky --fresh-env -c docs . $(SITE)
	@echo "the site is $(SITE)/index.html"

# The gates, all that they are made of, and their tests.
GATES := operator_site.safety remote_site.safety common.safety
GATE_TESTS := $(addprefix tests/unit/,$(subst .,/,$(GATES)))

.PHONY: coverage
coverage: $(READY)
	$(BIN)/pytest -q -n 2 $(GATE_TESTS) --cov-branch --cov-report=term-missing --cov-fail-under=100 \
		$(addprefix --cov=,$(GATES))

.PHONY: everything
everything: $(READY)
	$(BIN)/python -m tests.everything $(PIECES)

.PHONY: dask
dask: $(READY)
	$(BIN)/pytest -m dask tests/unit/studies

.PHONY: exports
exports: $(READY)
	$(LOCKED) locks/exports.txt
	$(BIN)/pytest -m exports tests/unit/teletaction tests/packaging tests/system/test_outlet.py

.PHONY: examples
examples: $(READY)
	$(LOCKED) locks/examples.txt
	NOTEBOOKS=$(NOTEBOOKS) $(BIN)/pytest -m examples -n 2 tests/examples

# An interrupted run continues; `teletaction study --compare OLD NEW` prints what became worse.
.PHONY: results
results: $(READY)
	$(BIN)/teletaction study --all --out $(RESULTS) $(ARGUMENTS)

.PHONY: picture
picture: $(READY) $(OUT)/session.mcap
	$(BIN)/python -c 'from pathlib import Path; \
		from teletaction.report.report import write_figure; from teletaction.recordings.session_data import SessionData; \
		write_figure(SessionData.read(Path("$(OUT)/session.mcap")), Path("docs/session.png"))'

.PHONY: console-picture
console-picture: $(READY)
	$(LOCKED) locks/browser.txt
	$(BIN)/python -m tests.browser.readme_picture docs/console.png

$(OUT)/session.mcap:
	$(MAKE) demo

.PHONY: tables
tables: $(READY)
	$(BIN)/python -c 'from datetime import date; from pathlib import Path; \
		from teletaction.make_tables import make_tables; \
		make_tables(Path("remote_site/tables"), made_on=str(date.today()))'

.PHONY: rungs
rungs: $(READY)
	$(BIN)/python -c 'from operator_site.thermal.model_selection import TABLE; \
		from operator_site.thermal.model_error import make_rungs; make_rungs(TABLE)'

.PHONY: budget
budget: $(READY)
	$(BIN)/python -m benchmarks.runtime_cost.budget

# constraints.txt has the versions, locks/ the hashes of all their files, so for all processors and Python versions.
# Versions stay as they are unless ARGUMENTS=--upgrade, or --upgrade-package NAME.
COMPILE := UV_CUSTOM_COMPILE_COMMAND='make lock' $(BIN)/uv pip compile --system-certs --quiet --universal --python-version 3.11 --no-annotate
HASHED := $(COMPILE) --generate-hashes -c constraints.txt
TOOLS := docs browser mutants examples supply installer
# Large packages, which only exports need: a lock of their own.
EXPORTS := dicom pandas parquet rerun foxglove lsl quality
.PHONY: lock
lock: $(READY)
	$(LOCKED) locks/supply.txt
	$(COMPILE) --all-extras $(addprefix --group=,dev exports $(TOOLS)) $(ARGUMENTS) pyproject.toml -o constraints.txt
	$(HASHED) --extra console --extra privacy pyproject.toml -o locks/run.txt
	$(HASHED) --extra camera --extra console pyproject.toml -o locks/camera.txt
	$(HASHED) $(addprefix --extra ,camera console metrics privacy studies dask) --group=dev pyproject.toml -o locks/dev.txt
	$(HASHED) $(addprefix --extra ,$(EXPORTS)) --group=exports pyproject.toml -o locks/exports.txt
	for name in $(TOOLS); do $(HASHED) --group=$$name -o locks/$$name.txt || exit; done

# A fresh environment holds what the image holds: the locked packages. Run it after `make lock` and on a new version.
.PHONY: sbom
sbom: $(READY)
	$(LOCKED) locks/supply.txt
	rm -rf build/sbom
	$(BIN)/python -m venv --without-pip build/sbom
	$(BIN)/pip --python build/sbom/bin/python install --quiet --no-deps --require-hashes -r locks/run.txt
	$(BIN)/cyclonedx-py environment --pyproject pyproject.toml --output-reproducible --of JSON -o $(SBOM) build/sbom/bin/python
	$(BIN)/python -m tests.packaging.trim_sbom $(SBOM)
	@echo "the bill of materials is $(SBOM)"

# Asks a public database for known weaknesses of the locked versions. A version that it does not know is an error.
.PHONY: audit
audit: $(READY)
	$(LOCKED) locks/supply.txt
	$(BIN)/pip-audit --strict --require-hashes --disable-pip -r locks/run.txt

.PHONY: golden
golden: $(READY)
	$(BIN)/python -m tests.golden.make_golden $(ARGUMENTS)

.PHONY: clean
clean:
	rm -rf .venv $(OUT) $(SOAK_OUT) $(SITE) build .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis .coverage *.egg-info
