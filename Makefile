# Two commands do all the set-up on a fresh machine: `make demo` (140 MB) and `make test` (8 GB). `make test-core` tests the
# core with 180 MB.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
SCENE  := examples/chessboard.scene
ROOMS  := grammar interpreter stdlib backends scenelang

.PHONY: demo dev playground play descriptions check types test test-blender lint install bench faults eval-recorded gallery docs site viewer build-page blocks tables editors chromium wheel release test-core test-install test-gpu test-hostile test-faults test-python fuzz test-grammar test-minecraft test-s3 test-slow test-nightly test-browser train-toy clean

# What the package needs, then the tools of development; redone when the project's files change.
$(VENV)/.run: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt .
	touch $@

# The extras whose pictures and texts the documentation and the benchmark show.
$(VENV)/.shown: $(VENV)/.run
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt ".[final,text,repl,meshes]"
	touch $@

$(VENV)/.dev: $(VENV)/.run
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt ".[dev]"
	touch $@

SOURCES := $(shell find $(ROOMS) -name node_modules -prune -o \( -name '*.py' -o -name '*.lark' -o -name '*.scene' \
  -o -name 'py.typed' -o -name 'catalogue.toml' -o -name '*.tsv.gz' -o -path '*/inference/prompts/*' -o -path '*/viewer/static/*' -o -path '*/deepslate/static/*' \) -print)

# The list of these files, which changes when one is deleted or moved too.
$(VENV)/.files: $(VENV)/.run FORCE
	@echo $(SOURCES) | cmp -s - $@ || echo $(SOURCES) > $@
FORCE:

# The package itself, installed as users get it (no editable install), so that packaging is tested too.
$(VENV)/.package: $(VENV)/.run $(VENV)/.files $(SOURCES)
	rm -rf build $(VENV)/.editable
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	rm -rf build *.egg-info
	touch $@

install: $(VENV)/.package

# The repository itself as the installed package: an edit is live. `make install` goes back to an installed copy.
$(VENV)/.editable: $(VENV)/.dev
	$(BIN)/python -m pip uninstall --quiet --yes scenelang
	rm -rf $(VENV)/lib/python*/site-packages/scenelang  # bytecode that was left there would be found first
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	rm -rf build *.egg-info $(VENV)/.package
	touch $@

dev: $(VENV)/.editable $(VENV)/live

# The packages as mypy finds them without an installation: links into the repository.
$(VENV)/live: $(VENV)/.dev $(wildcard scenelang/*)
	rm -rf $@ && mkdir -p $@/scenelang
	ln -s $(CURDIR)/scenelang/* $(foreach room,$(filter-out scenelang,$(ROOMS)),$(CURDIR)/$(room)) $@/scenelang
	touch $@

types: $(VENV)/live
	cd $(VENV) && MYPYPATH=live bin/mypy --config-file ../pyproject.toml --cache-dir .mypy-live -p scenelang

# In under a minute: lint, types, and the tests of what differs from SINCE, the nearest first.
SINCE ?= HEAD
check: $(VENV)/.dev types
	@test -e $(VENV)/.editable -o -e $(VENV)/.package || $(MAKE) --no-print-directory dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python -P tests/affected.py $(SINCE)

demo: install
	mkdir -p out
	$(BIN)/scenelang render $(SCENE) -o out/chessboard.png --quality draft --size 800x600
	@echo "the picture is out/chessboard.png"

lint: $(VENV)/.dev $(VENV)/.package
	$(BIN)/ruff check --no-cache .
	$(BIN)/ruff format --check --no-cache .
	$(BIN)/codespell
	@# One core each: 40 s beside the two minutes of mypy.
	$(BIN)/bandit --quiet --recursive --configfile pyproject.toml $(ROOMS) & bandit=$$!; \
	  (cd $(VENV) && bin/mypy --config-file ../pyproject.toml -p scenelang); types=$$?; wait $$bandit && exit $$types

# The viewer's page is tested in a browser; without one those tests say so and are skipped.
chromium:
	@if ! command -v chromium >/dev/null && command -v apt-get >/dev/null && [ "$$(id -u)" = 0 ]; then \
	  (apt-get update -qq && apt-get install -y -qq chromium) >/dev/null 2>&1 || true; fi

# Neighboring tests go to one worker, so that what a module's tests share is made once; bytecode of the tests is kept.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/pytest -n 2 --dist worksteal

test: lint chromium $(VENV)/.validator $(VENV)/.three $(VENV)/.textmate
	$(PYTEST) -m "not gpu and not slow and not browser"

# The tests that need no neural packages, with another Python: `make test-python PY=python3.13`.
PY ?= python3.12
OTHER := $(VENV)/$(notdir $(PY))
NEURAL := clip diffusion distillation grounding imagine inversion metrics splats wording
$(OTHER)/.ready: pyproject.toml constraints.txt
	$(PY) -m venv $(OTHER)
	$(OTHER)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt ".[final,text,repl,meshes,minecraft,usd,draco,lm,lsp,mcp,notebook,video,site,datasets]" \
	  webdataset datasets pycolmap trackeval lark pytest pytest-xdist hypothesis pexpect pytest-lsp nbclient ipykernel pycocotools build setuptools nbtlib mcschematic llguidance
	touch $@

test-python: $(OTHER)/.ready
	$(OTHER)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	rm -rf build *.egg-info
	$(OTHER)/bin/python -P -m pytest -n 2 --dist worksteal -q -m "not gpu and not slow and not browser" $(addprefix --ignore=tests/,$(NEURAL))

# The tests of the core, in an environment that has little else: 180 MB instead of 8 GB.
CORE := $(VENV)/core
IN_CORE := $(addprefix tests/,test_language lint formatter stdlib release test_reader.py test_bad.py test_combinators.py \
  test_primitives.py test_sharing.py test_linear.py exports/test_scene_json.py)
$(CORE)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(CORE)
	$(CORE)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt . pytest pytest-timeout pytest-xdist hypothesis pyyaml
	touch $@

test-core: $(CORE)/.ready
	$(CORE)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	rm -rf build *.egg-info
	$(CORE)/bin/python -P -m pytest -n 2 --dist worksteal -q -m "not gpu and not slow and not browser" $(IN_CORE)

# Installs the package as the README, the Dockerfile and other Pythons do, in clean environments: minutes, most of them downloads.
test-install: $(VENV)/.dev $(VENV)/.package
	$(BIN)/pytest -m slow tests/release

# Searches at random for long, and what takes more than a minute: an hour or more.
test-nightly: $(VENV)/.dev $(VENV)/.package
	$(PYTEST) --hypothesis-profile nightly -m "(hypothesis or search or slow) and not gpu and not browser"

# The Khronos glTF validator, where node and npm are; its tests say when it is not there.
GLTF_VALIDATOR := gltf-validator@2.0.0-dev.3.10
$(VENV)/.validator: $(VENV)/.run
	-command -v npm >/dev/null && npm install --silent --no-audit --no-fund --prefix $(VENV)/gltf-validator $(GLTF_VALIDATOR)
	touch $@

# three.js, whose loader reads GLB files in the tests, where node and npm are; its tests say when it is not there.
THREE := three@0.187.0
$(VENV)/.three: $(VENV)/.run
	-command -v npm >/dev/null && npm install --silent --no-audit --no-fund --prefix $(VENV)/three $(THREE)
	touch $@

# The engine that VS Code colors by, where node and npm are; its tests say when it is not there.
TEXTMATE := vscode-textmate@9.3.2 vscode-oniguruma@2.0.1
$(VENV)/.textmate: $(VENV)/.run
	-command -v npm >/dev/null && npm install --silent --no-audit --no-fund --prefix $(VENV)/textmate $(TEXTMATE)
	touch $@

# The GBNF form in xgrammar, which brings torch (gigabytes), so it has its own environment.
GRAMMAR := $(VENV)/grammar
$(GRAMMAR)/.ready: $(VENV)/.run
	$(PYTHON) -m venv $(GRAMMAR)
	$(GRAMMAR)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt lark pytest llguidance "xgrammar>=0.2" .
	touch $@

test-grammar: $(GRAMMAR)/.ready
	$(GRAMMAR)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	rm -rf build *.egg-info
	$(GRAMMAR)/bin/python -P -m pytest tests/grammar_export/test_xgrammar.py

# Files of builds in litemapy, whose licence is the GPL, so nothing else may need it.
MINECRAFT := $(VENV)/minecraft
$(MINECRAFT)/.ready: $(VENV)/.run
	$(PYTHON) -m venv $(MINECRAFT)
	$(MINECRAFT)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt pytest hypothesis mcschematic litemapy ".[meshes]"
	touch $@

test-minecraft: $(MINECRAFT)/.ready
	$(MINECRAFT)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	rm -rf build *.egg-info
	$(MINECRAFT)/bin/python -P -m pytest tests/minecraft/test_other_libraries.py

# Datasets in a store of the S3 protocol, whose packages need an older python-dateutil than the pinned one.
S3 := $(VENV)/s3
$(S3)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(S3)
	grep -v '^python-dateutil==' constraints.txt > $(S3)/constraints.txt
	$(S3)/bin/python -m pip install --quiet --disable-pip-version-check -c $(S3)/constraints.txt s3fs "aiobotocore>=3" "moto[s3,server]>=5.1" pytest hypothesis ".[cluster]"
	touch $@

test-s3: $(S3)/.ready
	$(S3)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	rm -rf build *.egg-info
	$(S3)/bin/python -P -m pytest -m slow tests/datasets/test_s3.py

# GLB and USD files imported into Blender's module, which has wheels for few versions of Python and its own environment.
BLENDER := $(VENV)/blender
$(BLENDER)/.ready: $(VENV)/.run
	$(PYTHON) -m venv $(BLENDER)
	@$(BLENDER)/bin/python -m pip install --quiet --disable-pip-version-check "bpy>=4.2" || \
	  { rm -rf $(BLENDER); echo "test-blender: there is no bpy for this Python; PYTHON=python3.11 has one"; exit 1; }
	touch $@

test-blender: $(VENV)/.dev $(VENV)/.package $(BLENDER)/.ready
	$(BIN)/pytest tests/exports/test_blender.py tests/blender

test-gpu: $(VENV)/.dev $(VENV)/.package
	$(BIN)/pytest -m gpu

# Hostile programs, each a process of its own under a limit of a second and 300 MB, measured from outside.
test-hostile: $(VENV)/.dev $(VENV)/.package
	cd tests && ../$(BIN)/python -P -c "import sys; sys.path.insert(0, '.'); from hostile.__main__ import main; sys.exit(main())"

# Planted faults, each run against the tests that reach it, in a checkout of COMMIT under .faults: an hour on one core.
COMMIT ?= HEAD
test-faults: $(VENV)/.dev
	cd tests && ../$(BIN)/python -P -c "import sys; sys.path.insert(0, '.'); from faults.__main__ import main; sys.exit(main('$(COMMIT)'))"

# `make fuzz TARGET=reader N=20000`: inputs until there were so many in all; .fuzz keeps the count and what was found.
TARGET ?= all
N ?= 20000
fuzz: $(VENV)/.dev $(VENV)/.package
	cd tests && ../$(BIN)/python -P -c "import sys; sys.path.insert(0, '.'); from fuzz.__main__ import main; sys.exit(main('$(TARGET)', '$(N)'))"

test-slow: $(VENV)/.dev $(VENV)/.package
	$(BIN)/pytest -m slow

# The viewer's page in a browser, and pictures with the game's own looks, where there are textures (SCENELANG_MINECRAFT, or
# the game itself).
test-browser: $(VENV)/.dev $(VENV)/.package chromium playground
	$(BIN)/pytest -m browser

# What is handed out: dist/*.tar.gz, and the wheel that is built from it, in a small environment of its own. `pipx install
# dist/*.whl` installs the command.
PACKAGING := $(VENV)/packaging
$(PACKAGING)/.ready:
	$(PYTHON) -m venv $(PACKAGING)
	$(PACKAGING)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt build twine
	touch $@

wheel: $(PACKAGING)/.ready
	rm -rf dist build *.egg-info
	$(PACKAGING)/bin/python -m build --outdir dist .
	rm -rf build *.egg-info

# Builds what is published, checks it in a clean environment, and says what is left to do.
release: $(PACKAGING)/.ready
	$(PACKAGING)/bin/python .ci/release.py

# Every row of the benchmark with its goal, and an entry of its history: 15 minutes; `make bench ONLY=fib` for some rows.
# What it is measured beside has an environment of its own; the language server and USD files are optional packages.
PEERS := $(VENV)/bench
$(PEERS)/.ready: benchmarks/peers.txt $(VENV)/.run
	$(PYTHON) -m venv $(PEERS)
	$(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check -r benchmarks/peers.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt pygls usd-core
	touch $@

ONLY ?=
bench: $(VENV)/.shown install $(PEERS)/.ready
	$(BIN)/python benchmarks/run.py "$(ONLY)"

# Recall and precision of the lint and of simulations on planted faults, written into docs/checker.md and docs/physics.md.
faults: $(VENV)/.shown install
	$(BIN)/python benchmarks/planted.py

# The numbers that tasks state, counted in the responses of language models that the tests keep.
eval-recorded: $(VENV)/.shown install
	$(BIN)/python benchmarks/recorded.py

gallery: $(VENV)/.shown install
	$(BIN)/python docs/gallery.py

# The reference, docs/reference, from the tables of the program, and the pictures of the tutorial.
docs: $(VENV)/.shown install
	PYTHONPATH=docs $(BIN)/python -m generator  # from here, because recipes name files of the repository
	cd docs && ../$(BIN)/python -m generator.walkthroughs

# The documentation as a static site in .site, with search that works from files; it needs no network once it is installed.
SITE := $(VENV)/lib/mkdocs-material
$(SITE): $(VENV)/.run
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt ".[site]"
	touch $@

site: $(SITE) $(VENV)/.package
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict
	@echo "the site is .site/index.html"

# The viewer's page from its source; what it makes is committed, so that only changes of it need npm.
viewer:
	cd backends/viewer/source && npm install --no-package-lock --no-audit --no-fund --silent && node build.mjs

# The playground: a static site with the interpreter in the browser. `make play` serves it on this machine.
PLAYGROUND := .playground
playground: $(VENV)/.dev $(VENV)/.package
	mkdir -p $(PLAYGROUND)
	$(BIN)/python -P -m scenelang.playground.archive $(PLAYGROUND) examples
	cd backends/viewer/source && npm install --no-package-lock --no-audit --no-fund --silent && node build.mjs $(abspath $(PLAYGROUND))
	@echo "the site is $(PLAYGROUND)/, to be served by any web server: make play"

play: playground
	$(BIN)/python -m http.server --bind 127.0.0.1 --directory $(PLAYGROUND) 8000

# The page of builds with the game's looks from its source; committed as the viewer's is. It shares some of the viewer's source.
build-page:
	cd backends/deepslate/source && npm install --no-package-lock --no-audit --no-fund --silent && node build.mjs

# What is known of a backend before it is imported: names, endings, options.
descriptions: $(VENV)/.editable
	$(BIN)/python -m scenelang.backends.described_backends

# The table of Minecraft's blocks from data and pictures of half a gigabyte; committed, so that only a new version needs it.
BLOCKS := $(VENV)/blocks
blocks: install
	npm install --no-audit --no-fund --silent --ignore-scripts --prefix $(BLOCKS) minecraft-data@3.117.0 minecraft-assets@1.19.0
	$(BIN)/python -m scenelang.backends.minecraft.extract $(BLOCKS) 26.1 backends/minecraft

# The small diffusion model that the tests distil from, from synthetic pictures; committed, ten minutes on one core.
train-toy: $(VENV)/.dev $(VENV)/.package
	PYTHONPATH=tests $(BIN)/python -m toy.train

# The parser's tables from the grammars, the names of the builtins, and the signatures of Python mode; committed, so that only a change of a grammar or a
# new builtin needs it.
tables: $(VENV)/.dev install
	$(BIN)/python -P -m scenelang.grammar.table_making grammar/tables
	$(BIN)/python -P -m scenelang.stdlib.library stdlib/builtin_names.py
	$(BIN)/python -P -m scenelang.stdlib.reference interpreter/runtime/modelling_signatures.py

# What the extension for VS Code takes from the language; committed, so that its folder packages by itself.
editors: $(VENV)/.shown install
	$(BIN)/python -P -m scenelang.reference.highlight editors/vscode

clean:
	rm -rf $(VENV) .site build out *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
