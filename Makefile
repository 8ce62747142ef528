# `make demo` and `make test` need the Rust toolchain and nothing else.

CARGO ?= cargo

.PHONY: demo test bench lint

# The main job on an embedded example; writes to uvgraft-demo/.
demo:
	$(CARGO) run --quiet --release --locked -p uvgraft-cli -- demo

# Tests with real meshes run where UVGRAFT_DATA names their folder, and say so where they are skipped.
test:
	$(CARGO) test --locked --workspace

# Times of each stage; on real meshes too where UVGRAFT_DATA names their folder.
bench:
	$(CARGO) bench --locked -p uvgraft-tests

lint:
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets -- -D warnings
	$(CARGO) clippy --locked -p uvgraft --no-default-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps
