# Sourced by .ci/run: lets cargo keep its outputs in the user's cache folder, so that later clones do not compile the packages of
# others again. POSIX sh.

# Sets CARGO_TARGET_DIR, unless it is set, no compiler tells its version, or another run uses the folder.
use_package_cache() {
    [ -z "${CARGO_TARGET_DIR:-}" ] || return 0
    caches=${XDG_CACHE_HOME:-${HOME:-}/.cache}/quadratura/packages
    compiler=$(PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin" rustc --version --verbose 2>/dev/null) || return 0
    of_compiler=$(printf '%s\n' "$compiler" | cksum | cut -d ' ' -f 1)
    key=$of_compiler-$(cksum <Cargo.lock | cut -d ' ' -f 1)
    cache=$caches/$key
    # Other packages with the same compiler: cargo uses what fits of them.
    older=$(ls -dt "$caches/$of_compiler"-* 2>/dev/null | head -n 1)
    [ -e "$cache" ] || [ -z "$older" ] || is_in_use "$older" || mv "$older" "$cache" 2>/dev/null || true
    mkdir -p "$cache" 2>/dev/null || return 0
    ! is_in_use "$cache" || return 0
    echo $$ >"$cache/in-use"
    trap 'rm -f "$cache/in-use"' EXIT
    # Outputs for other compilers and packages; what this project's own packages were compiled to in another clone.
    find "$caches" -mindepth 1 -maxdepth 1 ! -name "$key" -mtime +7 -exec rm -rf {} + 2>/dev/null || true
    [ "$(cat "$cache/clone" 2>/dev/null || true)" = "$PWD" ] || rm_own_outputs
    printf '%s' "$PWD" >"$cache/clone"
    export CARGO_TARGET_DIR="$cache"
}

# is_in_use FOLDER: the process that uses it is named in it; of one that was killed nothing but the name is left.
is_in_use() {
    user=$(cat "$1/in-use" 2>/dev/null || true)
    [ -n "$user" ] && kill -0 "$user" 2>/dev/null
}

# Removes what cargo made of the packages of this repository: it never uses that again for a clone in another folder.
rm_own_outputs() {
    own=$(sed -n 's/^name = "\(.*\)"$/\1/p' Cargo.toml src/*/Cargo.toml examples/*/Cargo.toml)
    tests=$(ls tests benches examples | sed 's/\.rs$//')
    for name in $own $tests; do
        file=$(printf '%s' "$name" | tr '-' '_')
        rm -rf "$cache"/*/deps/"$file"-* "$cache"/*/deps/lib"$file"-* "$cache"/*/.fingerprint/"$name"-* "$cache"/*/incremental/"$file"-*
    done
}

use_package_cache
