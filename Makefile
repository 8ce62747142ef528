# `make demo` needs the Rust toolchain and nothing else, and does more where there are a C++ compiler and
# npm; so does `make test`, which tests more where there are Python, Chromium and a network too.

CARGO ?= cargo

# The metric FLIP is C++, and so is what makes meshes simpler.
CXX_FOUND := $(shell command -v c++ 2>/dev/null)
SIMPLIFY := $(if $(CXX_FOUND),--features uvgraft-cli/simplify)
NATIVE := $(if $(CXX_FOUND),--features uvgraft-cli/flip --features uvgraft-tests/flip $(SIMPLIFY))

# The page of `uvgraft view` is JavaScript, made by scripts/build-viewer.sh with npm. Whether it is there
# is known when that is done.
VIEWER = $$(test ! -s target/viewer/viewer.html || echo --features uvgraft-cli/viewer)
VIEWER_TESTS = $$(test ! -s target/viewer/viewer.html || echo --features uvgraft-cli/viewer,uvgraft-tests/viewer)

.PHONY: demo test bench bench-scaling bench-peers book lint fixtures package viewer test-ktx2 test-clients

# The main job on an embedded example; writes to uvgraft-demo/.
demo: viewer
	$(CARGO) run --quiet --release --locked -p uvgraft-cli $(SIMPLIFY) $(VIEWER) -- demo

# The page of `uvgraft view`.
viewer:
	@scripts/build-viewer.sh

# Tests with real meshes run where UVGRAFT_DATA names their folder, and say so where they are skipped.
test: viewer
	@scripts/fetch-test-data.sh
	@scripts/install-browser.sh
	@test -n "$(CXX_FOUND)" || \
		echo "there is no C++ compiler (c++): tests of FLIP and of simplifying are skipped"
	$(CARGO) test --locked --workspace $(NATIVE) $(VIEWER_TESTS)

# Avatars in Debian's Blender and Godot, which are half a gigabyte.
test-clients:
	@scripts/install-clients.sh
	UVGRAFT_CLIENTS=1 $(CARGO) test --locked --workspace $(NATIVE) $(VIEWER_TESTS) --test clients

# The encoder of KTX2 textures, a minute of C++ that few need.
test-ktx2:
	$(CARGO) test --locked -p uvgraft-gltf --features ktx2 -- glb:: scene::
	$(CARGO) clippy --locked -p uvgraft-cli --features ktx2 -- -D warnings

# Times of each stage; on real meshes too where UVGRAFT_DATA names their folder.
bench:
	$(CARGO) bench --locked -p uvgraft-tests --bench stages --bench bodies

# How costs grow with the size of a texture and with the triangles of a mesh.
bench-scaling:
	$(CARGO) bench --locked -p uvgraft-tests --bench scaling

# Resampling and whole transfers beside OpenCV's and PyTorch's, by Python packages under target/:
# make bench-peers PEERS="--pair my.uvpair --threads 4"
PEERS ?=
PEERS_VENV := target/peers-venv
bench-peers:
	$(CARGO) build --release --locked -p uvgraft-cli
	test -x $(PEERS_VENV)/bin/pip || python3 -m venv --clear $(PEERS_VENV) || \
		{ echo "bench-peers: wanted python3 with its module venv" >&2; exit 1; }
	$(PEERS_VENV)/bin/pip install --quiet --requirement benches/peers/requirements.txt || \
		{ echo "bench-peers: could not install OpenCV and NumPy; is there a network?" >&2; exit 1; }
	$(PEERS_VENV)/bin/python benches/peers/peers.py $(PEERS)

# The libraries that also work without threads, and all their features but that.
LIBRARIES := uvgraft uvgraft-metrics uvgraft-io uvgraft-avatar uvgraft-gltf uvgraft-render uvgraft-figure
THREADLESS := $(LIBRARIES:%=-p %) --no-default-features \
	--features uvgraft/serde,uvgraft-metrics/flip,uvgraft-metrics/lpips,uvgraft-metrics/serde \
	--features uvgraft-metrics/ssimulacra2,uvgraft-io/lpips,uvgraft-gltf/ktx2,uvgraft-gltf/simplify
lint:
	@scripts/build-viewer.sh
	$(CARGO) fmt --all --check
	$(CARGO) clippy --locked --workspace --all-targets $(NATIVE) $(VIEWER_TESTS) -- -D warnings
	for library in $(LIBRARIES); do \
		$(CARGO) clippy --locked -p $$library --no-default-features -- -D warnings || exit 1; \
	done
	@tree=$$($(CARGO) tree --locked $(THREADLESS) --edges normal --prefix none) && \
		! echo "$$tree" | grep '^rayon' || \
		{ echo "lint: rayon must not be a dependency without the feature threads" >&2; exit 1; }
	@CARGO="$(CARGO)" scripts/check-wasm.sh
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace --no-deps

# The book, in target/book.
book:
	@scripts/build-book.sh

# The crates as they are published, each built from its package.
package:
	$(CARGO) package --locked --workspace --exclude uvgraft-tests

# Reference values that metrics and body models are tested against, by Python packages of 6 GB
# under target/.
FIXTURES := crates/uvgraft-tests/fixtures
fixtures:
	CI=1 scripts/fetch-test-data.sh
	test -d target/fixtures-venv || python3 -m venv target/fixtures-venv
	target/fixtures-venv/bin/pip install --quiet --requirement $(FIXTURES)/requirements.txt
	target/fixtures-venv/bin/python $(FIXTURES)/metrics.py target/test-data > target/metrics.json
	mv target/metrics.json $(FIXTURES)/metrics.json
	target/fixtures-venv/bin/python $(FIXTURES)/bodies.py > target/bodies.json
	mv target/bodies.json $(FIXTURES)/bodies.json
