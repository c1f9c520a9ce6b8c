#!/bin/sh
# A project made by several workers, with job schedulers of others: sh tests/farm.sh [PROGRAM TOWN]
#
# A small town is planned for Snakemake and for Open Job Description and made by two workers; its stacks have to be those of one
# `update`, byte for byte. Workers are killed at random moments, and so is Snakemake; what is run again gives the same bytes.
# Snakemake and openjd-cli are installed in an environment of their own; what cannot be had is left out by name. The commands for
# OpenCue are run by a shell. PHOTOS (8), WIDTH (600) and KILLS (4) may be set. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
. examples/setup.sh
whole() { (cd "$(dirname "$1")" && printf '%s/%s' "$PWD" "$(basename "$1")"); }
if [ $# -eq 2 ]; then
    program=$(whole "$1")
    town=$(whole "$2")
else
    [ $# -eq 0 ] || fail "usage: sh tests/farm.sh [PROGRAM TOWN]"
    check_rust
    check_c_compiler
    build_program town
    program=$(whole "$built/quadratura")
    town=$(whole "$built/town")
fi
check_vulkan
has python3 || { say "farm: left out, because python3 is missing"; exit 0; }
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1
began=$(date +%s)
step() { printf '== %4d s  %s\n' $(($(date +%s) - began)) "$*"; }

# have TOOL PACKAGE: installs a tool of the schedulers, unless it is there.
tools=$(whole "${CARGO_TARGET_DIR:-target}")/farm-python
have() {
    [ -x "$tools/bin/$1" ] && return
    [ -x "$tools/bin/python" ] || python3 -m venv "$tools" >/dev/null 2>&1 || { say "farm: $2 is left out: no python3-venv"; return 1; }
    say "set-up: installing $2 below $tools"
    "$tools/bin/python" -m pip install --quiet "$2" && [ -x "$tools/bin/$1" ] && return
    say "farm: $2 is left out, because it could not be installed"
    return 1
}

work=$(mktemp -d)
running=
trap '[ -z "$running" ] || kill "$running" 2>/dev/null; rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
photos=${PHOTOS:-8}
"$town" "$work/town" --photos "$photos" --width "${WIDTH:-600}" >/dev/null
memory="--memory 512M"
# Two machines of one core each; a machine's cores change no bytes.
plan="--cores 1 $memory"
# project NAME: a new project of the same site, beside the photos as all of them are.
project() {
    "$program" --quiet new "$work/$1" --photos "$work/town/photos" --cameras "$work/town/sparse" --model "$work/town/town.obj" >/dev/null
}
# bytes NAME: the hash of each file of the stacks.
bytes() { (cd "$work/$1/stacks" && find . -type f | sort | xargs sha256sum); }
# same NAME WHO: the stacks are those of one machine.
same() {
    bytes "$1" >"$work/$1.bytes"
    diff "$work/alone.bytes" "$work/$1.bytes" >"$work/diff" || { head -n 20 "$work/diff" >&2; fail "$2 made other stacks"; }
    left=$(find "$work/$1" -name '+new-*' -o -name '.quadratura-*' -o -path '*/cache/locks/*' | head -n 3)
    [ -z "$left" ] || fail "$2 left something behind: $left"
    step "$2: the same bytes"
}

project alone
# shellcheck disable=SC2086 # several words
"$program" --quiet update "$work/alone" $memory >/dev/null
bytes alone >"$work/alone.bytes"
step "one machine: $(wc -l <"$work/alone.bytes") files of $photos photos"

# Commands side by side, as people give them.
project together
# shellcheck disable=SC2086
"$program" --quiet build "$work/together" --part 1/2 --stacks-only $memory >/dev/null &
running=$!
"$program" --quiet build "$work/together" --part 2/2 --stacks-only $memory >/dev/null
wait "$running"
running=
"$program" --quiet fill "$work/together" --part 1/2 $memory >/dev/null &
running=$!
"$program" --quiet fill "$work/together" --part 1/2 $memory >/dev/null
wait "$running"
running=
"$program" --quiet update "$work/together" $memory >/dev/null
same together "two commands at a time, also on the same photos"

project listed
# shellcheck disable=SC2086
"$program" --quiet plan "$work/listed" --for cuecmd --out "$work/cue" $plan --photos-per-job 2 >/dev/null
# The lists name the program as it is installed.
mkdir "$work/bin"
ln -s "$program" "$work/bin/quadratura"
PATH="$work/bin:$PATH"
export PATH
for list in "$work"/cue/*.txt; do
    # As cuecmd does, each line by a shell; two at a time.
    xargs -P 2 -I LINE sh -c LINE <"$list" >/dev/null 2>"$work/log" || { cat "$work/log" >&2; fail "$(basename "$list")"; }
done
sh -n "$work/cue/submit.sh"
same listed "the commands for OpenCue"

if have openjd openjd-cli; then
    project template
    # shellcheck disable=SC2086
    "$program" --quiet plan "$work/template" --for openjd --out "$work/openjd" $plan --photos-per-job 2 --frames photos --ldi --exports >/dev/null
    "$tools/bin/openjd" check "$work/openjd/template.json" >/dev/null || fail "openjd refuses the template"
    "$tools/bin/openjd" run "$work/openjd/template.json" -p "Program=$program" >"$work/log" 2>&1 ||
        { tail -n 30 "$work/log" >&2; fail "openjd run"; }
    same template "Open Job Description"
    [ "$(find "$work/openjd/frames" -name '*.png' | wc -l)" -eq "$photos" ] || fail "frames are missing"
    [ "$(find "$work/template/cache/ldi" -name '*.ldi' | wc -l)" -eq "$photos" ] || fail "layered depth images are missing"
    [ "$(find "$work/openjd/exports" -name '*.psd' | wc -l)" -eq "$photos" ] || fail "exports are missing"
fi

if have snakemake snakemake; then
    snakemake() {
        (cd "$work/$1" && exec "$tools/bin/snakemake" --cores 2 --quiet all --rerun-incomplete --config "program=$program") >"$work/log" 2>&1
    }
    project rules
    # shellcheck disable=SC2086
    "$program" --quiet plan "$work/rules" --for snakemake --out "$work/snake" $plan --photos-per-job 2 >/dev/null
    snakemake snake || { tail -n 30 "$work/log" >&2; fail "Snakemake"; }
    same rules "Snakemake, two workers"

    project killed
    # shellcheck disable=SC2086
    "$program" --quiet plan "$work/killed" --for snakemake --out "$work/kill" $plan --photos-per-job 1 >/dev/null
    # The first living process that holds a lock: workers say in their locks who they are.
    worker() {
        for process in $(cat "$work"/killed/cache/locks/*.lock 2>/dev/null | sed -n 's/.*"process":\([0-9]*\).*/\1/p'); do
            kill -0 "$process" 2>/dev/null && echo "$process" && return
        done
        true
    }
    killed=0
    for kill in $(seq "${KILLS:-4}"); do
        snakemake kill &
        running=$!
        # A moment as random as the scheduler's start, and then the first at which somebody works.
        while [ -z "$(worker)" ] && kill -0 "$running" 2>/dev/null; do sleep 0.02; done
        sleep "$(awk -v seed="$kill" 'BEGIN { srand(seed); printf "%.2f", 0.6 * rand() }')"
        at_work=$(worker)
        while [ -z "$at_work" ] && kill -0 "$running" 2>/dev/null; do
            sleep 0.02
            at_work=$(worker)
        done
        [ -n "$at_work" ] && kill -9 "$at_work" 2>/dev/null && killed=$((killed + 1))
        # Snakemake lets the other worker finish, starts no more, and says that a job failed.
        wait "$running" || true
        running=
    done
    [ "$killed" -gt 0 ] || fail "nobody was killed: take more photos, or larger ones"
    snakemake kill || { tail -n 30 "$work/log" >&2; fail "Snakemake, after $killed were killed"; }
    "$program" status "$work/killed" | grep -q 'everything is done' || fail "status says otherwise"
    same killed "$killed workers killed, and run again"
fi
step "farm: passed"
