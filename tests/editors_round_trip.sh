#!/bin/sh
# Exports through image editors and back through this project's own readers, in every format and depth:
# sh tests/editors_round_trip.sh
#
# GIMP 2.10 opens what was exported, paints on one layer, saves it as XCF and as PSD, in 8 and in 16 bits;
# Krita opens and saves PSD, XCF and OpenRaster. Every layer that was not painted on has to come back with
# every sample and at its place. To be run by hand, on a photo of the sample project and on one of the castle
# where it is at hand; GIMP, Krita and xvfb-run have to be there. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
. examples/setup.sh
. tests/editors/run.sh

for editor in gimp-console krita xvfb-run; do
    has $editor || fail "$editor is missing; on Debian: apt-get install gimp krita xvfb xauth"
done
gimp_fits

target=${CARGO_TARGET_DIR:-target}
step "building"
cargo build --release --quiet --bin quadratura --example compare_layers --example invented_exports
program=$target/release/quadratura
compare=$target/release/examples/compare_layers

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
quiet_home

# proven WHO BEFORE AFTER [OPTION]...: one line; anything that changed ends the script.
proven() {
    who=$1
    shift
    found=$("$compare" same "$@") || fail "$who: compare_layers same $*"
    step "  $who: $found"
}

# through_gimp FILE: painted on and saved in both formats; taken to 16 bits and saved in both.
through_gimp() {
    name=$("$compare" name "$1")
    token=${name##*[}
    token=${token%]}
    for kind in xcf psd; do
        rm -f "$work"/painted.* "$work"/wide.*
        gimp "(paint-and-save \"$1\" \"$name\" \"$work/painted.$kind\")"
        proven "GIMP, ${1##*.} painted on, saved as $kind" "$1" "$work/painted.$kind" --painted "$token"
        gimp "(save-with-precision \"$1\" $GIMP_U16 \"$work/wide.$kind\")"
        proven "GIMP, ${1##*.} in 16 bits, saved as $kind" "$1" "$work/wide.$kind"
    done
}
GIMP_U16=250 # its number for 16 bits with the tone curve of the profile

# masks FILE: a layer with a mask, an opacity and a mode, a copy of it, a hidden group, a larger canvas; GIMP saves
# that four times, and the four have to say the same.
masks() {
    rm -f "$work"/masked*
    gimp "(change-and-save \"$1\" $GIMP_U16 \"$work/masked\")"
    for file in masked.psd masked16.xcf masked16.psd; do
        proven "GIMP, masked.xcf against $file" "$work/masked.xcf" "$work/$file" --other-format
    done
}

# through_krita FILE: saved as PSD. Krita cuts off what is transparent around a layer.
through_krita() {
    rm -f "$work/krita.psd"
    krita_saves "$1" "$work/krita.psd"
    proven "Krita, ${1##*.} saved as psd" "$1" "$work/krita.psd" --cropped
}

# all_formats PHOTO FOLDER: what was exported of a photo of 8 bits.
all_formats() {
    for kind in xcf psd ora; do
        file=$2/$1.$kind
        step "$1.$kind: $("$compare" list "$file" | tail -n 1)"
        case $kind in
            # Debian's GIMP 2.10 has no OpenRaster.
            ora) ;;
            *) through_gimp "$file" ;;
        esac
        through_krita "$file"
    done
    rm -f "$work/krita.ora"
    krita_saves "$2/$1.ora" "$work/krita.ora"
    proven "Krita, ora saved as ora" "$2/$1.ora" "$work/krita.ora" --cropped
}

# exported TITLE PHOTOS CAMERAS MODEL: a project with one photo built and exported in every format.
exported() {
    "$program" -q new "$work/$1" --photos "$2" --cameras "$3" --model "$4" >/dev/null
    photo=$(ls "$2" | head -n 1)
    "$program" -q build "$work/$1" --photo "$photo" >/dev/null
    for kind in xcf psd ora; do
        "$program" -q export "$work/$1" --photo "$photo" --format $kind --out "$work/$1-out" >/dev/null
    done
    all_formats "$photo" "$work/$1-out"
}

"$target/release/examples/invented_exports" "$work/invented"
masks "$work/invented/out/eight.png.xcf"
all_formats eight.png "$work/invented/out"
for kind in xcf psd; do
    file=$work/invented/out/sixteen.png.$kind
    step "sixteen.png.$kind: $("$compare" list "$file" | tail -n 1)"
    through_gimp "$file"
done
# Krita before version 5.2 reads XCF in 8 bits only.
through_krita "$work/invented/out/sixteen.png.psd"

sample=projects/piazza
exported piazza $sample/photos $sample/sparse $sample/piazza.obj
castle=../shared/data/castle
if [ -d "$castle" ]; then
    exported castle $castle/images $castle/sparse $castle/castle.obj
fi
step "every layer came back"
