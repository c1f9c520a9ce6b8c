#!/bin/sh
# The main job on the sample project: photos and a coarse model become layer stacks, written as files
# for an image editor; and the stacks become pictures from viewpoints that no photo was taken from.
#
#     sh examples/demo.sh [FOLDER]        default: target/demo
#
# Everything is written below FOLDER. What is there already is never deleted: a folder that is not
# empty gets a number.
set -eu
asked=${1:-}
case $asked in '' | /*) ;; *) asked=$PWD/$asked ;; esac
cd "$(dirname "$0")/.."
. examples/setup.sh

out=${asked:-$PWD/target/demo}
wanted=$out
number=2
while [ -n "$(ls -A "$out" 2>/dev/null)" ]; do
    out=$wanted-$number
    number=$((number + 1))
done

build_program paint_mural
program=$built/quadratura
sample=projects/piazza
project=$out/project

step() { say && say "\$ quadratura $*" && "$program" "$@"; }

mkdir -p "$out"
step new "$project" --photos "$sample/photos" --cameras "$sample/sparse" --model "$sample/piazza.obj"
step check "$project"
step update "$project"
step export "$project" --format psd --out "$out/psd"
step export "$project" --format ora --out "$out/ora"
step export "$project" --format folder --out "$out/folder"
say
say "A round window is painted on the church, as an artist would in an image editor, and imported:"
"$built/paint_mural" "$out/psd/01_church.jpg.psd" church.facade
step import "$project" "$out/psd/01_church.jpg.psd"
step import "$project" --history
say
say "The paint is projected onto the other photos of the same wall:"
step update "$project"
step info "$project"
step render "$project" --cameras "$sample/heldout/sparse" --out "$out/views" --scale 0.5
step score "$project" --cameras "$sample/heldout/sparse" --photos "$sample/heldout/photos" --ignore 'tree_*' \
    --ignore-background --pictures "$out/differences"
step render "$project" --cameras "$sample/flight.json" --out "$out/flight" --size 480x270 --fps 8 \
    --quality preview --video "$out/flight.apng"

say
say "The square as a web page, in which one walks:"
step export "$project" --format page --out "$out/page" --title "The square"

say
say "Where to look:"
say "  $out/psd        one layered file per photo: open it in GIMP, Krita or Photoshop"
say "  $out/ora        the same for Krita and MyPaint"
say "  $out/folder     the same as PNG files with stack.json"
say "  $out/views      the square from viewpoints of photos that are not in the project"
say "  $out/differences  those photos, their predictions, and where they differ"
say "  $out/flight.apng  a flight across the square: open it in a browser"
say "  $out/page       the square as a web page: open index.html in a browser"
say "  $project        the project; docs/formats.md says what is in it"

# A window, if there is a display.
case $(uname) in
    Linux) shown=${WAYLAND_DISPLAY:-}${DISPLAY:-} ;;
    *) shown=yes ;;
esac
if [ -n "$shown" ] && [ "${CI:-}" != true ]; then
    say
    say "And the editor, with the same project; F1 shows what keys and mouse do:"
    step edit "$project"
else
    say
    say "With a display, \`quadratura edit $project\` opens the same in a window."
fi
