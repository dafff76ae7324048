# Every target sets up what it needs; `make demo` and `make test` work on a fresh machine.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: setup demo test check bench format lock proto clean

setup: .venv/.ready .venv/.compiled

# The lock names every file's hash. uv installs itself from the same lock, so nothing but
# Python 3.11 with its venv module is wanted.
.venv/.ready: requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "setup: Python 3.11 or newer is needed; name one: make setup PYTHON=python3.12"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv || \
		{ echo "setup: python3 -m venv failed; on Debian: apt-get install python3-venv"; exit 1; }
	@sed -n '/^uv==/,/[^\\]$$/p' requirements.lock > .venv/uv.lock.txt
	$(BIN)/python -m pip install --quiet --require-hashes -r .venv/uv.lock.txt
	$(BIN)/uv pip sync --quiet --python $(BIN)/python --require-hashes requirements.lock
	$(BIN)/uv pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation --offline --editable .
	@touch $@

# Kernels are compiled once for this checkout; a changed source is compiled again when it is used.
.venv/.compiled: | .venv/.ready
	$(BIN)/python -m services.warm_up
	@touch $@

demo: setup
	$(BIN)/gazemap demo

test: setup
	$(BIN)/python -m pytest

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: setup
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: setup
	$(BIN)/gazemap bench all

lock:
	$(BIN)/uv pip compile --quiet --generate-hashes --no-emit-index-url --no-header --extra dev --python-version 3.11 pyproject.toml -o requirements.lock

# The generated code is committed; this is the command that made it.
proto: setup
	cd gazemap/wire/proto && ../../../$(BIN)/python -m grpc_tools.protoc -I. \
		--plugin=protoc-gen-mypy=../../../$(BIN)/protoc-gen-mypy \
		--python_out=../generated --mypy_out=../generated *.proto

clean:
	rm -rf .venv build dist
