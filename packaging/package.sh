#!/bin/sh
# The package for Debian and its kin, and the same files as an archive: sh packaging/package.sh OUT [PROGRAM]
#
# Writes OUT/quadratura_VERSION_ARCH.deb and OUT/quadratura-VERSION-ARCH.tar.gz. Without PROGRAM it is built for release first. The
# same program gives the same bytes: times are those of the last commit (or of SOURCE_DATE_EPOCH). MAINTAINER='NAME <ADDRESS>' says who
# answers for the package. POSIX sh; needs python3 for the
# licences, and dpkg-deb for the package.
set -eu
say() { printf '%s\n' "$*"; }
fail() { printf 'package: %s\n' "$*" >&2; exit 1; }
[ $# -ge 1 ] && [ $# -le 2 ] || fail "usage: sh packaging/package.sh OUT [PROGRAM]"
mkdir -p "$1"
out=$(cd "$1" && pwd)
program=${2:-}
[ -z "$program" ] || program=$(cd "$(dirname "$program")" && pwd)/$(basename "$program")
cd "$(dirname "$0")/.."
for tool in python3 dpkg-deb gzip tar readelf; do
    command -v "$tool" >/dev/null 2>&1 || fail "$tool is needed"
done

if [ -z "$program" ]; then
    # Paths of the machine that built it are of no use to others.
    home=${CARGO_HOME:-${HOME:-}/.cargo}
    RUSTFLAGS="${RUSTFLAGS:-} --remap-path-prefix=$PWD=quadratura --remap-path-prefix=$home=cargo" \
        cargo build --release --locked --bin quadratura
    program=${CARGO_TARGET_DIR:-target}/release/quadratura
fi
[ -x "$program" ] || fail "$program is no program"
# 1 to 9: how long it is packed.
level=${LEVEL:-6}
version=$("$program" --version | cut -d ' ' -f 2)
arch=$(dpkg --print-architecture)
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
export SOURCE_DATE_EPOCH

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
root=$work/root
put() { install -D -m "${3:-644}" "$1" "$root/$2"; }
made() { mkdir -p "$(dirname "$root/$1")" && cat >"$root/$1"; }
put "$program" usr/bin/quadratura 755
strip --strip-unneeded "$root/usr/bin/quadratura" 2>/dev/null || say "package: not stripped"
"$program" completions bash | made usr/share/bash-completion/completions/quadratura
"$program" completions zsh | made usr/share/zsh/vendor-completions/_quadratura
"$program" completions fish | made usr/share/fish/vendor_completions.d/quadratura.fish
"$program" man | gzip -9n | made usr/share/man/man1/quadratura.1.gz
put packaging/quadratura.desktop usr/share/applications/quadratura.desktop
put packaging/quadratura.svg usr/share/icons/hicolor/scalable/apps/quadratura.svg
put packaging/quadratura.xml usr/share/mime/packages/quadratura.xml
doc=usr/share/doc/quadratura
for file in README.md LICENSE-MIT LICENSE-APACHE; do put "$file" "$doc/$file"; done
gzip -9nc CHANGELOG.md | made "$doc/changelog.gz"
python3 packaging/licences.py | gzip -9n | made "$doc/licences-of-packages.txt.gz"
made "$doc/copyright" <<END
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: Quadratura

Files: *
Copyright: the authors of Quadratura
License: Expat or Apache-2.0
 See LICENSE-MIT and LICENSE-APACHE beside this file. The packages that are compiled in have their own licences; they are in
 licences-of-packages.txt.gz.
END
find "$root" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
ordered() { tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner "$@"; }
archive=$out/quadratura-$version-$arch.tar.gz
ordered --transform "s,^\./usr,quadratura-$version," -C "$root" -cf - ./usr | gzip "-${level}n" >"$archive"

# The youngest C library whose functions the program names.
libc=$(readelf -V "$root/usr/bin/quadratura" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -n 1)
made DEBIAN/control <<END
Package: quadratura
Version: $version
Architecture: $arch
Maintainer: ${MAINTAINER:-The authors of Quadratura}
Installed-Size: $(du -sk --apparent-size "$root/usr" | cut -f 1)
Depends: libc6 (>= ${libc#GLIBC_}), libgcc-s1
Recommends: libvulkan1, mesa-vulkan-drivers | vulkan-driver, libxkbcommon0, libwayland-client0 | libx11-6
Suggests: ffmpeg, gimp, krita
Section: graphics
Priority: optional
Description: photos of a site as image layers, projected onto a model
 From calibrated photos of a site and a coarse polygon model, Quadratura turns
 every photo into a stack of image layers for GIMP, Krita or Photoshop, sorted
 by proven visibility, fills what the photo does not show, and projects all of
 it back onto the model: for new views, flights and layered depth images.
END
(cd "$root" && find usr -type f | sort | xargs md5sum) | made DEBIAN/md5sums
deb=$out/quadratura_${version}_$arch.deb
dpkg-deb --root-owner-group -Zxz "-z$level" --build "$root" "$deb" >/dev/null
say "$deb"
say "$archive"
