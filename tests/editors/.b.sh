#!/bin/sh
# Models with textures, read by what reads them elsewhere: sh tests/editors/baked.sh
#
# Khronos' validator reads the GLB, USD's own validators and cameras the stage, with and without tiles, and OpenEXR the layers, of the
# sample project with four photos. What cannot be had of node and Python's packages is left out and named. POSIX sh.
set -eu
cd "$(dirname "$0")/../.."
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
. examples/setup.sh
mkdir -p "${CARGO_TARGET_DIR:-target}"
target=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)

:
program=/tmp/ways/q3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM

sample=projects/piazza
photos="--photo 01_church.jpg --photo 02_from_southwest.jpg --photo 04_arcade.jpg --photo 08_portrait.jpg"
"$program" -q new "$work/project" --photos $sample/photos --cameras $sample/sparse --model $sample/piazza.obj >/dev/null
# shellcheck disable=SC2086
"$program" -q build "$work/project" $photos >/dev/null
export_as() {
    format=$1 folder=$2
    shift 2
    # shellcheck disable=SC2086
    "$program" -q export "$work/project" --format "$format" --out "$work/$folder" $photos "$@" >/dev/null 2>"$work/said" ||
        { cat "$work/said" && fail "export --format $format"; }
}
export_as glb glb --density 20
export_as usd usd --density 20
export_as usd tiles --density 20 --udim --page-size 1024
export_as cameras cameras
export_as exr exr

if has node && npm install --silent --prefix "$target/editors-node" gltf-validator >/dev/null 2>&1; then
    say "gltf-validator: $(node tests/editors/gltf.mjs "$target/editors-node" "$work/glb/site.glb")" || fail "the GLB"
else
    say "left out: gltf-validator, for which node and npm are needed"
fi

python=$target/editors-python/bin/python
[ -x "$python" ] || python3 -m venv "$target/editors-python" 2>/dev/null || true
if "$python" -m pip install --quiet usd-core 2>/dev/null; then
    for stage in "$work/usd/site.usda" "$work/usd/site.usdz" "$work/tiles/site.usda"; do
        said=$("$python" tests/editors/usd.py "$stage" "$work/cameras/cameras.json") || fail "$stage: $said"
        say "usd-core: $said"
    done
else
    say "left out: usd-core, for which Python's venv and pip are needed"
fi

if "$python" -m pip install --quiet OpenEXR numpy pillow 2>/dev/null; then
    for photo in 01_church.jpg 08_portrait.jpg; do
        said=$("$python" tests/editors/exr.py "$work/exr/$photo.exr" "$sample/photos/$photo" "$work/project/stacks/$photo/stack.json") ||
            fail "$photo.exr: $said"
        say "OpenEXR: $said"
    done
else
    say "left out: OpenEXR, for which Python's venv and pip are needed"
fi
