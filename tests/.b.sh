#!/bin/sh
# An export for Blender, built and drawn by Blender: sh tests/blender.sh
#
# The sample project: every camera through Blender's own matrices, and 200 random ones; what Blender shows from the cameras of two
# photos, one of them off-centre and upright, against these photos; paint that Blender saves comes back. Blender is the Python
# module bpy, in an environment below the build's folder; where it cannot be had, this is left out. Minutes. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
. examples/setup.sh

# The version that docs/handover.md was written with.
blender=4.5.15
target=${CARGO_TARGET_DIR:-target}
python=$target/blender-python/bin/python

left_out() { say "left out: Blender: $*"; exit 0; }

if ! "$python" -c 'import bpy' 2>/dev/null; then
    has python3.11 || left_out "its module needs Python 3.11, which is not there"
    say "set-up: installing bpy $blender below $target (1 GB)"
    python3.11 -m venv "$target/blender-python" || left_out "Python made no environment"
    "$python" -m pip install --quiet "bpy==$blender" numpy || left_out "bpy $blender could not be installed"
fi
:
program=/tmp/ways/q3

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
sample=projects/piazza
check() { "$python" tests/blender/check.py "$@" 2>"$work/log" || { cat "$work/log"; fail "Blender: $*"; }; }
# Blender says much about each tile.
quiet() { grep -v -e '^Fra:' -e '^Saved' -e '^ Time' -e '^$' || true; }

"$program" -q new "$work/site" --photos $sample/photos --cameras $sample/sparse --model $sample/piazza.obj >/dev/null
"$program" -q update "$work/site" >/dev/null
"$program" -q export "$work/site" --format blender --out "$work/blender" >/dev/null
check cameras "$work/blender"
check pictures "$work/blender" "$work" 01_church.jpg 08_portrait.jpg >"$work/pictures" || { cat "$work/pictures"; exit 1; }
quiet <"$work/pictures"

layers=$work/blender/layers/01_church.jpg.layers
largest=$(cd "$layers" && ls -S ./*.png | head -n 1)
check paint "$layers" "$largest"
"$program" import "$work/site" "$layers" | tee "$work/import"
grep -q painted "$work/import" || fail "Blender: the paint was not imported"
say "Blender shows the photos, and its paint came back"
