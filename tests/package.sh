#!/bin/sh
# The package: built, installed, used on the sample project, removed: sh tests/package.sh [PROGRAM]
#
# Without PROGRAM it is built for release. Where this is not root, the package is unpacked instead of installed. POSIX sh.
set -eu
cd "$(dirname "$0")/.."
. examples/setup.sh
for tool in dpkg-deb python3 readelf; do
    has "$tool" || { say "package: left out, because $tool is missing"; exit 0; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
# Packed quickly; what is packed is the same.
export LEVEL=1
sh packaging/package.sh "$work/one" ${1:+"$1"} >/dev/null
sh packaging/package.sh "$work/two" "${1:-${CARGO_TARGET_DIR:-target}/release/quadratura}" >/dev/null
deb=$(echo "$work"/one/quadratura_*.deb)
for file in "$work"/one/*; do
    cmp "$file" "$work/two/$(basename "$file")" || fail "the same program gives other bytes: $(basename "$file")"
done

root=$work/root
mkdir -p "$root"
# The places of files, without the records of dpkg itself.
places() { (cd "$root" && find . -path ./var -prune -o -print | sort); }
installs=
if [ "$(id -u)" -eq 0 ] && has dpkg; then
    installs=yes
    mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates" "$root/usr/bin" "$root/usr/share"
    : >"$root/var/lib/dpkg/status"
    : >"$root/var/lib/dpkg/available"
    # What other packages have, or dpkg removes these folders, too.
    touch "$root/usr/bin/other" "$root/usr/share/other"
    places >"$work/before"
    dpkg --root="$root" --force-depends --force-not-root --install "$deb" >/dev/null 2>"$work/log" || { cat "$work/log" >&2; fail "dpkg"; }
else
    say "package: not root, so it is unpacked and not installed"
    dpkg-deb -x "$deb" "$root"
fi
for file in bin/quadratura share/bash-completion/completions/quadratura share/zsh/vendor-completions/_quadratura \
    share/fish/vendor_completions.d/quadratura.fish share/man/man1/quadratura.1.gz share/applications/quadratura.desktop \
    share/icons/hicolor/scalable/apps/quadratura.svg share/mime/packages/quadratura.xml \
    share/doc/quadratura/copyright share/doc/quadratura/licences-of-packages.txt.gz; do
    [ -s "$root/usr/$file" ] || fail "the package lacks usr/$file"
done
for name in wgpu egui serde image; do
    gzip -dc "$root/usr/share/doc/quadratura/licences-of-packages.txt.gz" | grep -q "^$name [0-9]" ||
        fail "the licences lack $name"
done
[ "$(tar -tzf "$work"/one/*.tar.gz | grep -vc '/$')" -eq "$(dpkg-deb -c "$deb" | grep -vc '^d')" ] || fail "the archive has other files"
if has update-mime-database; then
    cp -r "$root/usr/share/mime" "$work/mime"
    update-mime-database "$work/mime" >/dev/null 2>&1 || fail "the MIME types are wrong"
    grep -q 'application/vnd.quadratura.ldi:\*.ldi' "$work/mime/globs" || fail "there is no type for *.ldi"
fi
has desktop-file-validate && desktop-file-validate "$root/usr/share/applications/quadratura.desktop"

quadratura=$root/usr/bin/quadratura
"$quadratura" sample "$work/piazza" >/dev/null
"$quadratura" info "$work/piazza/project" >/dev/null
check_vulkan
first=$("$quadratura" info "$work/piazza/project" --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["photos"][0]["photo"])')
"$quadratura" --quiet build "$work/piazza/project" --photo "$first" --stacks-only >/dev/null
[ -s "$work/piazza/project/stacks/$first/stack.json" ] || fail "the installed program has built nothing"

if [ -n "$installs" ]; then
    dpkg --root="$root" --force-not-root --purge quadratura >/dev/null 2>"$work/log" || { cat "$work/log" >&2; fail "dpkg"; }
    places >"$work/after"
    diff "$work/before" "$work/after" || fail "something is left of the package"
fi
say "package: built twice alike, used$([ -n "$installs" ] && echo ', removed without a trace')"
