# syntax=docker/dockerfile:1
#
# The command as one static binary in an empty image, for clusters:
#
#   docker build -t uvgraft --build-arg UVGRAFT_COMMIT="$(git rev-parse HEAD)" .
#   docker run --rm --read-only --network none --cap-drop ALL \
#       -v "$PWD:/data" -w /data --user "$(id -u):$(id -g)" uvgraft \
#       transfer head_to_body.uvpair faces/ --onto body.png -o bodies/ --skip-existing
#
# In a job of N indexed pods (Kubernetes sets JOB_COMPLETION_INDEX), each pod transfers one shard of the
# textures into the same folder; N is the number of completions of the job:
#
#   args: [transfer, head_to_body.uvpair, faces/, --onto, body.png, -o, bodies/, --skip-existing,
#          --shard, $(JOB_COMPLETION_INDEX)/64]
#
# docs/src/transfer.md has whole scripts, for Slurm too.

FROM rust:1.95-slim-bookworm AS build
WORKDIR /src
COPY . .
# For `uvgraft --version --verbose`; the image is built without the repository's history.
ARG UVGRAFT_COMMIT
# glibc is linked statically, which is safe here: the command looks up neither hosts nor users, for which
# glibc would load libraries when it runs. With a target of its own, the flags do not apply to build scripts
# and procedural macros, which must be dynamic.
RUN --mount=type=cache,target=/usr/local/cargo/registry \
    --mount=type=cache,target=/src/target \
    host=$(rustc -vV | sed -n 's/^host: //p') && \
    RUSTFLAGS='-C target-feature=+crt-static' \
        cargo build --release --locked -p uvgraft-cli --target "$host" && \
    cp "target/$host/release/uvgraft" /uvgraft && \
    # Dynamic after all, it would not start in an empty image.
    ldd /uvgraft 2>&1 | grep -Eq 'statically linked|not a dynamic executable'

FROM scratch
COPY --from=build /uvgraft /uvgraft
# Nobody. Output folders must be writable for it, or for the user that is set instead. The command writes
# nowhere but beside its outputs, so everything else can be read-only.
USER 65534:65534
ENTRYPOINT ["/uvgraft"]
