# How the scripts in this folder's parent run GIMP and Krita: to be read in with `.`, after
# examples/setup.sh. They set $work, a folder for what is made on the way.

# Names of layers are typed to GIMP in many scripts; a bare machine has no locale for them.
export LC_ALL=C.UTF-8

began=$(date +%s)
step() { printf '%4d s  %s\n' $(($(date +%s) - began)) "$*"; }

gimp_fits() {
    gimp-console --version | grep -q 'version 2\.' ||
        fail "tests/editors/gimp.scm speaks to GIMP 2.10, not to this one"
}

# A home of their own, so that nobody's settings matter; libraries grumble without the second one.
quiet_home() {
    mkdir -p "$work/home"
    chmod 700 "$work/home"
    export XDG_RUNTIME_DIR="$work/home"
}

# gimp EXPRESSION...: each is evaluated after tests/editors/gimp.scm.
gimp() {
    for expression in "$@"; do
        timeout 120 gimp-console -idf --no-data \
            -b "(begin (load \"tests/editors/gimp.scm\") $expression)" -b '(gimp-quit 0)' \
            >"$work/gimp.log" 2>&1 </dev/null || { cat "$work/gimp.log" && fail "GIMP: $expression"; }
    done
}

# Krita needs a display. A virtual one that is slow to start loses its client, which is no fault of
# the file: so three times. What Krita made is judged, not how it ended.
krita_saves() {
    for _ in 1 2 3; do
        HOME=$work/home timeout 120 xvfb-run -a krita --nosplash --export \
            --export-filename "$2" "$1" >"$work/krita.log" 2>&1 </dev/null || true
        [ -s "$2" ] && return
        sleep 2
    done
    cat "$work/krita.log"
    fail "Krita made no $2"
}
