#!/bin/sh
# Exports read back by those they are made for: sh tests/editors.sh [--all]
#
# psd-tools reads every layer; GIMP opens a PSD, paints on one layer, saves it, and every other layer has to come back bit for
# bit; Krita opens and saves PSD and OpenRaster; Chromium draws pages. On an invented stack of 8 bits; with --all also on one of
# 16 bits, as PSB, on a photo of the sample project, and on one of the castle where it is at hand.
# What is missing of GIMP, Krita, Chromium and psd-tools is installed, on Debian and its kin. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
# The build profile of tests/run.sh.
export QUADRATURA_PROFILE="${QUADRATURA_PROFILE:-ci}"
. examples/setup.sh
. tests/editors/run.sh
all=
case ${1:-} in '') ;; --all) all=yes ;; *) fail "usage: sh tests/editors.sh [--all]" ;; esac

# proven WHO COMMAND...: one line of tests/editors/layers.py; anything wrong ends the script.
proven() {
    who=$1
    shift
    found=$("$python" tests/editors/layers.py "$@") || fail "$who: layers.py $*"
    step "  $who: $found"
}

target=${CARGO_TARGET_DIR:-target}
python=python3

install_editors() {
    missing=
    has gimp-console || missing="$missing gimp"
    has krita || missing="$missing krita"
    has xvfb-run || missing="$missing xvfb xauth"
    has python3 || missing="$missing python3"
    has chromium || has chromium-browser || has google-chrome || missing="$missing chromium"
    [ -z "$missing" ] && return
    has apt-get || fail "please install$missing"
    # shellcheck disable=SC2086 # several packages
    apt_install "the editors that read the exports" $missing || fail "could not install$missing"
}

# In an environment of its own: Debian's Python refuses pip otherwise.
install_psd_tools() {
    "$python" -c 'import psd_tools, numpy, PIL' 2>/dev/null && return
    python=$target/editors-python/bin/python
    "$python" -c 'import psd_tools, numpy, PIL' 2>/dev/null && return
    python3 -c 'import venv, ensurepip' 2>/dev/null ||
        apt_install "psd-tools is installed with it" python3-venv || fail "could not install python3-venv"
    say "set-up: installing psd-tools, numpy and Pillow below $target"
    python3 -m venv "$target/editors-python"
    "$python" -m pip install --quiet psd-tools numpy Pillow
}

# through_gimp PSD PHOTO-FILE: opened, painted on, saved; and saved once more.
through_gimp() {
    name=$("$python" tests/editors/layers.py name "$1")
    token=${name##*[}
    token=${token%]}
    rm -f "$work/painted.psd" "$work/again.psd" "$work/picture.png" # GIMP ends well even when a script fails
    gimp "(paint-and-save \"$1\" \"$name\" \"$work/painted.psd\")" \
        "(save-again \"$work/painted.psd\" \"$work/again.psd\")" \
        "(save-picture \"$1\" \"$work/picture.png\")"
    proven "GIMP, painted on $name" same "$1" "$work/painted.psd" --painted "$token" --key
    proven "GIMP, saved again" same "$work/painted.psd" "$work/again.psd" --key
    proven "GIMP" picture "$work/picture.png" "$2"
}

# through_krita FILE PSD PHOTO-FILE [--about]: FILE opened and saved as a PSD is PSD; what is seen is the
# photo.
through_krita() {
    rm -f "$work/krita.psd" "$work/krita.png"
    krita_saves "$1" "$work/krita.psd"
    proven "Krita, ${1##*.}" same "$2" "$work/krita.psd" --cropped
    krita_saves "$1" "$work/krita.png"
    proven "Krita, ${1##*.}" picture "$work/krita.png" "$3" ${4:+"$4"}
}

# one_photo TITLE PROJECT PHOTO PHOTO-FILE: built and exported by the program, then through everything.
one_photo() {
    step "$1: $3"
    "$program" -q build "$2" --photo "$3" >/dev/null
    "$program" -q export "$2" --photo "$3" --out "$work/$1" >/dev/null
    psd=$work/$1/$3.psd
    proven "psd-tools" stack "$psd" "$2" "$3" "$4"
    through_gimp "$psd" "$4"
    through_krita "$psd" "$psd" "$4"
}

install_editors
gimp_fits
install_psd_tools
step "building"
cargo build --profile "$profile" --quiet --bin quadratura --example invented_exports
program=$built/quadratura

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
quiet_home

colours=/usr/share/color/icc/krita/sRGB-elle-V2-srgbtrc.icc
[ -e "$colours" ] || colours=
"$built/examples/invented_exports" "$work" ${colours:+"$colours"}
invented() {
    psd=$work/out/$1.png.psd
    step "invented, $1 bits"
    proven "psd-tools" stack "$psd" "$work/project" "$1.png" "$2"
    through_gimp "$psd" "$2"
}
file="$work/project/photo 1.png"
invented eight "$file"
through_krita "$psd" "$psd" "$file"
through_krita "$work/out/eight.png.ora" "$psd" "$file"
# What is slow and seldom finds more.
all_samples() {
    # Krita takes 16 bits to a profile of its own for PNG, and reads OpenRaster in 8 bits only.
    file="$work/project/photo 2.png"
    invented sixteen "$file"
    through_krita "$psd" "$psd" "$file" --about
    step "invented, PSB"
    proven "psd-tools" stack "$work/out/eight.png.psb" "$work/project" eight.png "$work/project/photo 1.png"

    sample=projects/piazza
    photo=$(ls $sample/photos | head -n 1)
    "$program" -q new "$work/sample" --photos $sample/photos --cameras $sample/sparse \
        --model $sample/piazza.obj >/dev/null
    one_photo piazza "$work/sample" "$photo" "$sample/photos/$photo"

    castle=../shared/data/castle
    if [ -d "$castle" ]; then
        photo=$(ls $castle/images | head -n 1)
        "$program" -q new "$work/castle-project" --photos $castle/images --cameras $castle/sparse \
            --model $castle/castle.obj >/dev/null
        one_photo castle "$work/castle-project" "$photo" "$castle/images/$photo"
    fi
}
[ -z "$all" ] || all_samples
step "pages, drawn by Chromium"
cargo test --profile "$profile" --quiet --test recipes page:: >/dev/null || fail "Chromium: tests/recipes/page.rs"
step "every layer came back${all:+, of all samples}"
