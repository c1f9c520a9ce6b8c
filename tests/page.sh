#!/bin/sh
# The page of the sample project, looked at as a visitor does: sh tests/page.sh
#
# A real Chromium opens it from disk and over http, walks by keys, by fingers and in an emulated headset, is given damaged data, and shows
# ten views, which are compared with what `render` makes of them; then the page of one photo. Without Chromium or Python this is left out and named. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
. examples/setup.sh

chromium=
for name in chromium chromium-browser google-chrome google-chrome-stable; do
    [ -n "$chromium" ] || chromium=$(command -v "$name" || true)
done
if [ -z "$chromium" ] || ! has python3; then
    say "left out: the page, for which Chromium and Python are needed"
    exit 0
fi

cargo build --profile "$profile" --quiet --bin quadratura
program=$built/quadratura
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM

sample=projects/piazza
"$program" -q new "$work/project" --photos $sample/photos --cameras $sample/sparse --model $sample/piazza.obj >/dev/null
"$program" -q update "$work/project" >/dev/null
"$program" -q export "$work/project" --format page --out "$work/page" --keep-coordinates --title "The square" >/dev/null
python3 tests/page/views.py "$work/page" $sample/heldout/sparse "$work/views"
"$program" -q render "$work/project" --cameras "$work/views/sparse" --out "$work/views/raw" --exposure raw --background none >/dev/null
"$program" -q render "$work/project" --cameras "$work/views/sparse" --out "$work/views/full" >/dev/null
"$program" -q ldi build "$work/project" --photo 03_from_southeast.jpg --out "$work/fountain.ldi" >/dev/null
"$program" -q ldi export "$work/fountain.ldi" --format page --out "$work/photo" >/dev/null
scripts=
mkdir -p "${CARGO_TARGET_DIR:-target}/editors-node"
node=$(cd "${CARGO_TARGET_DIR:-target}/editors-node" && pwd)
if has npm && npm install --silent --prefix "$node" axe-core iwer >/dev/null 2>&1; then
    scripts="$node/node_modules/axe-core/axe.min.js $node/node_modules/iwer/build/iwer.min.js"
else
    say "left out: axe-core, and a headset that iwer emulates, for which npm is needed"
fi
firefox=$(command -v firefox-esr || command -v firefox || true)
if [ -n "$firefox" ] && has xvfb-run && has xauth; then
    LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a python3 tests/page/firefox.py "$firefox" "$work/page" "$work/photo" "$work/views" ||
        fail "pages in Firefox"
else
    say "left out: pages in Firefox, for which firefox-esr, xvfb and xauth are needed"
fi
# shellcheck disable=SC2086
python3 tests/page/photo.py "$work/photo" "$chromium" $scripts || fail "the page of one photo"
# shellcheck disable=SC2086
python3 tests/page/check.py "$work/page" "$chromium" "$work/views" $scripts || fail "the page"
