#!/bin/sh
# How the program scales with the number of photos: sh tests/scale.sh [PHOTOS]...
#
# A synthetic town (examples/town) of 25, 100 and 400 photos, or of the numbers given, goes through all steps. For each step a line
# says what it took: processor seconds, for a photo where the step concerns all of them, seconds by the clock, peak memory, and
# what the project has on disk then. At the end the largest town is compared with the smallest.
#
# WORK=FOLDER keeps towns and projects there, and uses towns that are there already. QUADRATURA=PROGRAM measures that program.
# 400 photos take some hours on two cores without a GPU. POSIX sh; python3 with its standard library, on Linux.
set -eu
cd "$(dirname "$0")/.."
. examples/setup.sh
has python3 || fail "python3 is missing"
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1

if [ -z "${WORK:-}" ]; then
    WORK=$(mktemp -d)
    trap 'rm -rf "$WORK"' EXIT
    trap 'exit 130' INT TERM
fi
[ $# -gt 0 ] || set -- 25 100 400
for photos in "$@"; do
    [ -e "$WORK/town-$photos/made" ] && continue
    cargo run --quiet --profile "$profile" -p town -- "$WORK/town-$photos" --photos "$photos"
    : >"$WORK/town-$photos/made"
done
if [ -z "${QUADRATURA:-}" ]; then
    cargo build --quiet --profile "$profile"
    QUADRATURA=$built/quadratura
fi
python3 tests/scale/measure.py "$QUADRATURA" "$WORK" "$@"
