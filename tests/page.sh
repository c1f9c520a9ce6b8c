#!/bin/sh
# The page of the sample project, looked at as a visitor does: sh tests/page.sh
#
# A real Chromium opens it from disk and over http, walks by keys and fingers, is given damaged data, and shows ten views, which are
# compared with what `render` makes of them. Without Chromium or Python this is left out and named. POSIX sh.
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
axe=
mkdir -p "${CARGO_TARGET_DIR:-target}/editors-node"
node=$(cd "${CARGO_TARGET_DIR:-target}/editors-node" && pwd)
if has npm && npm install --silent --prefix "$node" axe-core >/dev/null 2>&1; then
    axe=$node/node_modules/axe-core/axe.min.js
else
    say "left out: axe-core, for which npm is needed"
fi
# shellcheck disable=SC2086
python3 tests/page/check.py "$work/page" "$chromium" "$work/views" $axe || fail "the page"
