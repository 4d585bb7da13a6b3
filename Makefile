.DEFAULT_GOAL := help
.PHONY: help demo test torture lint format extension clean

help: ## List these targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' Makefile

demo: .venv/.complete ## Render the test room once and relight it; the pictures are in out/demo
	@.venv/bin/relume demo --out out/demo

test: .venv/.complete ## Run the tests; with BLENDER="a command that runs Blender", in the real application too
	.venv/bin/pytest

torture: .venv/.complete ## Hostile input by the thousand (under half an hour); RELUME_SEED=N makes the same cases again
	RELUME_TORTURE=$${RELUME_TORTURE:-1} RELUME_SEED=$${RELUME_SEED:-$$(date +%s)} .venv/bin/pytest tests/faults tests/test_readme.py tests/core/test_palette_solve.py -m ""

lint: .venv/.complete ## Check style and format
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .

format: .venv/.complete ## Put the sources into the project's format
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .

extension: .venv/.complete ## Build the extension with its wheels, one zip for each platform, into build/
	.venv/bin/python tools/build_extension.py

clean: ## Remove everything that these targets made
	rm -rf .venv build out

.venv/.complete: pyproject.toml tools/make_venv.sh
	@tools/make_venv.sh
	@touch $@
