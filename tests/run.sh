#!/bin/sh
# Every test: sh tests/run.sh
#
# One build profile (release) serves program, demo, tests and benchmarks, so each package is compiled
# once. What needs GIMP, Krita or psd-tools is in tests/editors.sh.
set -eu
cd "$(dirname "$0")/.."
. examples/setup.sh

began=$(date +%s)
step() {
    now=$(($(date +%s) - began))
    printf '\n== %d:%02d %s\n' $((now / 60)) $((now % 60)) "$*"
}

# component NAME: rustup's minimal toolchain comes without rustfmt and clippy.
component() {
    cargo "$1" --version >/dev/null 2>&1 && return
    has rustup || fail "cargo $1 is missing; it belongs to the Rust toolchain (package $2 or rust-$2, or rustup)"
    say "set-up: installing the toolchain's component $2"
    rustup component add "$2"
}
component fmt rustfmt
component clippy clippy

# Where nobody is logged in, a layer of Mesa's prints an error about the missing desktop for every
# device; src/main.rs says more.
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1

step "scripts parse"
for script in examples/*.sh tests/*.sh tests/editors/*.sh .ci/run; do
    sh -n "$script"
done

step "formatted"
cargo fmt --check

step "tests"
cargo test --release --quiet

step "benchmarks compile"
cargo bench --quiet --no-run

step "clippy"
cargo clippy --release --quiet --all-targets -- -D warnings

step "documentation without warnings"
RUSTDOCFLAGS="-D warnings" cargo doc --release --quiet --no-deps

step "the demo"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' INT TERM
sh examples/demo.sh "$folder"

step "all tests passed"
