.DEFAULT_GOAL := help
.PHONY: help demo docs gallery test oldest torture lint format extension clean

help: ## List these targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' Makefile

demo: .venv/.complete ## Render the test room once and relight it; the pictures are in out/demo
	@.venv/bin/relume demo --out out/demo

docs: .venv/.complete ## Build the documentation's site into out/docs
	.venv/bin/python -m sphinx --fail-on-warning --keep-going --quiet --doctree-dir build/doctrees docs out/docs
	@echo out/docs/index.html

gallery: .venv/.complete ## Make the figures of the three papers again, in out/gallery; REFLECTANCES=the CSV that its tables are of
	.venv/bin/python -m relume.benchmarks.gallery $(if $(REFLECTANCES),--reflectances $(REFLECTANCES)) --out out/gallery

test: .venv/.complete ## Run the tests; with BLENDER="a command that runs Blender", in the real application too
	.venv/bin/pytest --numprocesses 2 --dist loadfile --no-loadscope-reorder --ignore tests/gui
	.venv/bin/pytest tests/gui

oldest: .venv-oldest/.complete ## Run the core's and the add-on's tests, or TESTS=..., in Blender 5.0 (Python 3.11)
	.venv-oldest/bin/pytest --numprocesses 2 --dist loadfile $(or $(TESTS),tests/core tests/addon)

torture: .venv/.complete ## Hostile input by the thousand (under half an hour); RELUME_SEED=N makes the same cases again
	RELUME_TORTURE=$${RELUME_TORTURE:-1} RELUME_SEED=$${RELUME_SEED:-$$(date +%s)} .venv/bin/pytest tests/faults tests/test_readme.py tests/core/test_palette_solve.py tests/addon/test_fidelity.py -m ""

lint: .venv/.complete ## Check style, format, types, and who imports whom
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy core studies
	.venv/bin/lint-imports --no-cache

format: .venv/.complete ## Put the sources into the project's format
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .

extension: .venv/.complete ## Build the extension with its wheels, one zip for each platform, into build/
	.venv/bin/python tools/build_extension.py

clean: ## Remove everything that these targets made
	rm -rf .venv .venv-oldest build out

.venv/.complete: pyproject.toml tools/make_venv.sh
	@tools/make_venv.sh
	@touch $@

.venv-oldest/.complete: pyproject.toml tools/make_venv.sh
	@tools/make_venv.sh .venv-oldest 3.11
	@touch $@
