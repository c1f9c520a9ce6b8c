#!/bin/sh
# The tests of every change: sh tests/run.sh
#
# One build profile (ci, in Cargo.toml) serves tests and editors, so each package is compiled once, and with settings that keep
# building and testing together short. What needs GIMP, Krita or psd-tools is in tests/editors.sh, and what is slow and seldom finds
# anything in tests/full.sh. Tests that this machine cannot run are counted at the end, with the reason.
set -eu
cd "$(dirname "$0")/.."
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
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

# Tests that are left out add a line each: reason, tab, name (tests/common/left_out.rs).
work=$(mktemp -d)
checking=
trap '[ -z "$checking" ] || kill "$checking" 2>/dev/null; rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
export LEFT_OUT_LOG="$work/left-out"
: >"$LEFT_OUT_LOG"

# report_left_out: what was left out, by reason.
report_left_out() {
    sort -u "$LEFT_OUT_LOG" | awk -F '\t' '
        $1 != reason { reason = $1; reasons[++count] = reason }
        { tests[reason]++; names[reason] = names[reason] "\n      " $2 }
        END {
            for (i = 1; i <= count; i++) {
                reason = reasons[i]
                printf "  %d left out, because %s:%s\n", tests[reason], reason, names[reason]
            }
        }'
}

# Where nobody is logged in, a layer of Mesa's prints an error about the missing desktop for every
# device; src/main.rs says more.
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1

step "scripts parse"
for script in examples/*.sh packaging/*.sh tests/*.sh tests/editors/*.sh .ci/run; do
    sh -n "$script"
done

step "formatted"
cargo fmt --all --check

step "tests compile"
cargo test --profile "$profile" --workspace --quiet --no-run

# Checks keep one core busy for the most part, and tests wait for files and for each other: beside each other they end
# sooner. The checks yield to the tests. All targets are checked, so benchmarks and examples compile, too.
checks() {
    trap 'kill $! 2>/dev/null; exit 143' TERM
    export RUSTDOCFLAGS="-D warnings"
    step "clippy"
    beside clippy --quiet --profile "$profile" --workspace --all-targets -- -D warnings
    step "documentation without warnings"
    beside doc --quiet --profile "$profile" --no-deps
    step "the library alone needs no window and no command line"
    unwanted=$(cargo tree --edges normal --no-default-features --prefix none | grep -E '^(eframe|egui|rfd|winit|clap)[ _-]' || true)
    [ -z "$unwanted" ] || fail "the library alone still needs: $unwanted"
    step "end of the checks"
}
# beside COMMAND...: of cargo; it ends with the checks.
beside() {
    nice -n 10 cargo "$@" &
    wait $!
}
(checks) >"$work/checks" 2>&1 &
checking=$!

step "tests"
cargo test --profile "$profile" --workspace --quiet

step "checks that ran beside the tests"
checked=0
wait "$checking" || checked=$?
checking=
cat "$work/checks"
[ "$checked" = 0 ] || fail "one of the checks above failed"

if [ -s "$LEFT_OUT_LOG" ]; then
    step "all tests passed that could run here; $(sort -u "$LEFT_OUT_LOG" | wc -l | tr -d ' ') were left out"
    report_left_out
else
    step "all tests passed"
fi
