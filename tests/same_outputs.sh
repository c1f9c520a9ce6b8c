#!/bin/sh
# Two programs give the same outputs: sh tests/same_outputs.sh OLD_PROGRAM NEW_PROGRAM [CASTLE_FOLDER]
#
# Both programs do the same work: project, check, stacks, filling, exports in every format, a painted file imported
# and exported again, paint propagated, pictures in final and preview quality, score, info. Then every file that one
# wrote is compared with the other's: byte for byte, and JSON after what is renamed on purpose
# (tests/same_outputs/renamed.txt) and what no two runs have alike (times, durations) is evened out. The
# differences are listed with the names of their files.
#
# PHOTOS=all in the environment takes all photos of the sample project; without it four, which takes some minutes.
# CASTLE_FOLDER holds images/, sparse/ and castle.obj of a second site; three of its photos are compared.
# WORK=FOLDER keeps what both wrote there. POSIX sh; python3 with its standard library.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
. "$here/examples/setup.sh"

usage='usage: sh tests/same_outputs.sh OLD_PROGRAM NEW_PROGRAM [CASTLE_FOLDER]'
[ $# -ge 2 ] && [ $# -le 3 ] || fail "$usage"
absolute() { case $1 in /*) printf '%s' "$1" ;; *) printf '%s/%s' "$PWD" "$1" ;; esac; }
old=$(absolute "$1")
new=$(absolute "$2")
castle=${3:+$(absolute "$3")}
for program in "$old" "$new"; do
    [ -x "$program" ] || fail "$program is not a program"
done
has python3 || fail "python3 is missing; it is of every Linux and of Xcode's command line tools"
helper=$here/tests/same_outputs/helper.py
renamed=$here/tests/same_outputs/renamed.txt
[ -n "${XDG_RUNTIME_DIR:-}" ] || export NODEVICE_SELECT=1

if [ -n "${WORK:-}" ]; then
    mkdir -p "$WORK"
    work=$(cd "$WORK" && pwd)
    [ -z "$(ls -A "$work")" ] || fail "$work is not empty"
else
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    trap 'exit 130' INT TERM
fi

# Both programs work in a folder of the same name, so that no path is another one.
run=$work/run

# does NAME ARGUMENT...: a command; what it prints is an output, too. (Status 1: one photo has a fault; as before.)
does() {
    name=$1
    shift
    status=0
    "$program" --quiet --json "$@" >"$run/said/$name.json" 2>"$run/said/$name.err" || status=$?
    [ $status -le 1 ] || fail "$program $* ended with status $status: $(tail -n 3 "$run/said/$name.err")"
    printf '%s\n' "$status" >"$run/said/$name.status"
}

# walk SITE PHOTO...: all of the work on some photos of a project that is made already.
walk() {
    site=$1
    shift
    project=$run/$site
    some=
    for photo in "$@"; do some="$some --photo $photo"; done
    # Names of the sample photos hold no spaces: they may be split.
    # shellcheck disable=SC2086
    does "$site-build" build "$project" $some
    does "$site-fill" fill "$project" $some
    for format in psd ora folder xcf; do
        does "$site-export-$format" export "$project" --format $format --out "$run/$site-$format" $some
    done
    does "$site-export-provenance" export "$project" --format ora --provenance --even-colour \
        --out "$run/$site-provenance" $some
    # The painted copy lies beside what was exported, which stays as it was.
    cp -Rp "$run/$site-folder" "$run/$site-painted"
    python3 "$helper" paint "$run/$site-painted/$1.layers" >"$run/said/$site-paint.txt"
    does "$site-import-looked-at" import "$project" --dry-run "$run/$site-painted/$1.layers"
    does "$site-import" import "$project" "$run/$site-painted/$1.layers"
    does "$site-propagate" fill "$project" $some --propagate
    does "$site-export-again" export "$project" --format psd --out "$run/$site-again" $some
    does "$site-info" info "$project"
    does "$site-render-final" render "$project" --through "$1,$2" --scale 0.2 --out "$run/$site-final"
    does "$site-render-preview" render "$project" --through "$1,$2" --scale 0.2 --quality preview \
        --out "$run/$site-preview"
    for show in confidence provenance weights; do
        does "$site-render-$show" render "$project" --through "$2" --scale 0.2 --show $show --out "$run/$site-$show"
    done
    does "$site-score" score "$project" --scale 0.15 --pictures "$run/$site-differences"
}

# outputs PROGRAM NAME: what a program makes of everything, as NAME.
outputs() {
    program=$1
    mkdir -p "$run/said"
    began=$(date +%s)
    sample=$here/projects/piazza
    does piazza-new new "$run/piazza" --photos "$sample/photos" --cameras "$sample/sparse" \
        --model "$sample/piazza.obj"
    does piazza-check check "$run/piazza"
    if [ "${PHOTOS:-}" = all ]; then
        # shellcheck disable=SC2046
        walk piazza $(cd "$sample/photos" && ls)
    else
        walk piazza 01_church.jpg 02_from_southwest.jpg 04_arcade.jpg 08_portrait.jpg
    fi
    does piazza-heldout render "$run/piazza" --cameras "$sample/heldout/sparse" --scale 0.25 --out "$run/piazza-heldout"
    if [ -n "$castle" ]; then
        does castle-new new "$run/castle" --photos "$castle/images" --cameras "$castle/sparse" \
            --model "$castle/castle.obj"
        # shellcheck disable=SC2046
        walk castle $(cd "$castle/images" && ls | sed -n '1p;4p;7p')
    fi
    mv "$run" "$work/$2"
    say "$2: $1, $(($(date +%s) - began)) s"
}

outputs "$old" old
outputs "$new" new
python3 "$helper" compare "$work/old" "$work/new" "$renamed"
