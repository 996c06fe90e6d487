# Two commands matter: `make demo` flies the demonstration, `make test` runs every check.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# AirSim's own client, which wants libraries of another age, for the scripts of tests/airsim/scripts.
CLIENT := .venv-airsim
JOBS ?= 2

export PYTEST_ADDOPTS

.PHONY: demo test pytest test-slow bench pictures lint style types clean

demo: $(VENV)/installed
	$(BIN)/crosstrack fly examples/demo.yaml --out runs/demo --png

# Types are checked while the tests run. Workers begin apart in the list of tests, so that what one of them has compiled
# is there when another comes to need it.
test: $(VENV)/installed-test $(CLIENT)/installed style
	$(MAKE) --no-print-directory --jobs 2 types pytest

pytest: $(VENV)/installed-test $(CLIENT)/installed
	$(BIN)/pytest -n $(JOBS) --dist worksteal -m "not slow"

test-slow: $(VENV)/installed-slow $(CLIENT)/installed
	$(BIN)/pytest -n $(JOBS) -m slow --fail-on-skip

bench: $(VENV)/installed-bench $(CLIENT)/installed
	for benchmark in benchmarks/*.py; do $(BIN)/python $$benchmark || exit 1; done

comma := ,
space := $(subst ,, )
FOLLOWERS := carrot pure_pursuit nlgl proportional_los vector_field npfg lqr_path move_on_path published_carrot
TRACKERS := feed_forward cascaded_pid lqr geometric incremental mpc

# The pictures of the documentation.
pictures: $(VENV)/installed
	for name in demo city article_four_points airsim_path_10; do \
		$(BIN)/crosstrack fly examples/$$name.yaml --out runs/$$name --png || exit 1; done
	cp runs/demo/plan.png docs/pictures/demo.png
	cp runs/city/space.png docs/pictures/city.png
	cp runs/article_four_points/plan.png docs/pictures/article_four_points.png
	cp runs/airsim_path_10/plan.png docs/pictures/airsim_path_10.png
	for name in swap_8 formation_forest; do \
		$(BIN)/crosstrack fly examples/$$name.yaml --out runs/$$name --png || exit 1; \
		cp runs/$$name/together.png docs/pictures/$$name.png; done
	$(BIN)/python examples/potential_field.py
	$(BIN)/python examples/airsim_views.py docs/pictures/airsim_views.png
	for law in $(FOLLOWERS); do \
		$(BIN)/crosstrack fly examples/square.yaml --out runs/$$law --png --set tracker.kind=$$law --set speed=8 \
			--set 'wind={mean: [3, 2, 0], gusts: moderate}' || exit 1; \
		cp runs/$$law/plan.png docs/pictures/law_$$law.png; done
	for law in $(TRACKERS); do \
		$(BIN)/crosstrack fly examples/fast_eight.yaml --out runs/$$law --png --set tracker.kind=$$law || exit 1; \
		cp runs/$$law/plan.png docs/pictures/law_$$law.png; done
	$(BIN)/crosstrack compare examples/square.yaml --out runs/followers --png --seeds 3 --set speed=8 \
		--trackers $(subst $(space),$(comma),$(FOLLOWERS)) \
		--wind calm --wind 3,2,0,moderate
	cp runs/followers/comparison.png docs/pictures/followers.png
	$(BIN)/crosstrack compare examples/fast_eight.yaml --out runs/trackers --png --seeds 3 \
		--trackers $(subst $(space),$(comma),$(TRACKERS))
	cp runs/trackers/comparison.png docs/pictures/trackers.png

lint: style types

style: $(VENV)/installed-test
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: $(VENV)/installed-test
	$(BIN)/mypy

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(0 if (3, 11) <= sys.version_info < (3, 14) else "Crosstrack needs Python 3.11 to 3.13, found " + sys.version.split()[0] + "; name another with: make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	touch $@

$(VENV)/installed-test: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test]"
	touch $@ $(VENV)/installed

$(VENV)/installed-slow: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test,cluster,rl]"
	touch $@ $(VENV)/installed-test $(VENV)/installed

$(VENV)/installed-bench: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[test,bench]"
	touch $@ $(VENV)/installed-test $(VENV)/installed

# Its setup imports what it depends on, and asks for more than it needs: hence in two steps, and without the rest.
$(CLIENT)/installed: tests/airsim/scripts/requirements.txt | $(VENV)/bin/python
	$(BIN)/python -m venv $(CLIENT)
	$(CLIENT)/bin/python -m pip install --quiet --disable-pip-version-check --requirement $<
	$(CLIENT)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation airsim==1.8.1
	touch $@

clean:
	rm -rf $(VENV) $(CLIENT) runs .mypy_cache .ruff_cache .pytest_cache .hypothesis
	find src tests benchmarks -name __pycache__ -prune -exec rm -rf {} +
