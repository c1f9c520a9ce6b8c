# What the program, the demo and the tests need of the machine. Sourced by examples/demo.sh and
# tests/run.sh, or run by itself: sh examples/setup.sh
#
# Checked: Rust, a C compiler, a Vulkan adapter. Only the last is installed, in software, on Debian
# and its kin; everything else is named, with the command that brings it. POSIX sh.

RUST_NEEDED=1.95

# The build profile: `release` for whoever runs the program; tests/run.sh takes another.
profile=${QUADRATURA_PROFILE:-release}
built=${CARGO_TARGET_DIR:-target}/$profile

say() { printf '%s\n' "$*"; }
fail() { printf 'set-up: %s\n' "$*" >&2; exit 1; }
has() { command -v "$1" >/dev/null 2>&1; }

# A toolchain installed a minute ago is on the PATH of the next login only.
has cargo || PATH="${CARGO_HOME:-${HOME:-}/.cargo}/bin:$PATH"
export PATH

check_rust() {
    has cargo && has rustc || fail "no Rust toolchain found; install one from https://rustup.rs"
    version=$(rustc --version | cut -d ' ' -f 2)
    major=${version%%.*}
    minor=${version#*.}
    minor=${minor%%.*}
    [ "$major" -gt 1 ] || [ "$minor" -ge "${RUST_NEEDED#*.}" ] && return
    fail "rustc $version found, $RUST_NEEDED or newer needed; try: rustup update stable"
}

# `cc` links every Rust program and compiles the hash function's assembler.
check_c_compiler() {
    has cc && return
    case $(uname -s) in
        Darwin) fail "no C compiler (cc) found; try: xcode-select --install" ;;
        *) fail "no C compiler (cc) found; on Debian or Ubuntu: apt-get install build-essential" ;;
    esac
}

# The Vulkan loader is looked for where the linker would find it.
has_vulkan_loader() {
    PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1' && return
    for library in /usr/lib/libvulkan.so.1 /usr/lib64/libvulkan.so.1 /usr/lib/*/libvulkan.so.1 \
        /usr/local/lib/libvulkan.so.1 /run/opengl-driver/lib/libvulkan.so.1; do
        [ -e "$library" ] && return
    done
    return 1
}

# The manifests that the loader would read, one a line.
vulkan_manifests() {
    chosen=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}
    if [ -n "$chosen" ]; then
        say "$chosen" | tr ':' '\n'
        return
    fi
    for folder in "${XDG_CONFIG_HOME:-${HOME:-}/.config}" "${XDG_DATA_HOME:-${HOME:-}/.local/share}" /etc/xdg /etc \
        /usr/local/share /usr/share /run/opengl-driver/share; do
        for manifest in "$folder"/vulkan/icd.d/*.json; do
            [ -e "$manifest" ] && say "$manifest"
        done
    done
}

# A driver for hardware counts where there is such hardware; one in software always does.
has_graphics_device() {
    for device in /dev/dri/renderD* /dev/nvidia0 /dev/dxg /dev/kgsl-3d0; do
        [ -e "$device" ] && return
    done
    return 1
}

has_vulkan_adapter() {
    has_vulkan_loader || return 1
    manifests=$(vulkan_manifests)
    case $manifests in
        '') return 1 ;;
        *lvp_icd* | *swiftshader*) return 0 ;;
        *) has_graphics_device ;;
    esac
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; elif has sudo; then sudo "$@"; else
        fail "root rights are needed; run as root: $*"
    fi
}

# apt_install REASON PACKAGE...: says first what it is about to do.
apt_install() {
    reason=$1
    shift
    say "set-up: installing $* ($reason)"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq </dev/null || return 1
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" \
        </dev/null >/dev/null
}

check_vulkan() {
    case $(uname -s) in
        Linux) ;;
        Darwin | MINGW* | MSYS* | CYGWIN*) return ;; # Metal and Direct3D 12 are part of the system
        *) say "set-up: cannot tell whether there is a Vulkan driver; the program will." && return ;;
    esac
    has_vulkan_adapter && return
    has apt-get || fail "no Vulkan adapter found; install your GPU's Vulkan driver, or Mesa's software one \
(Fedora: mesa-vulkan-drivers vulkan-loader; Arch: vulkan-swrast vulkan-icd-loader; \
openSUSE: libvulkan_lvp libvulkan1; Alpine: mesa-vulkan-swrast vulkan-loader)"
    apt_install "no Vulkan adapter was found; this is Mesa's, in software" mesa-vulkan-drivers libvulkan1 ||
        fail "that did not work; as root, with a network: apt-get install mesa-vulkan-drivers libvulkan1"
    has_vulkan_adapter || fail "there is still no Vulkan adapter after installing mesa-vulkan-drivers"
}

# build_program [PACKAGE]...: the program, and packages of this repository beside it, with cargo's own progress.
#
# The estimate is the processor time of a fresh build on two machines, a quick one and a slow one with much other load, divided by the
# cores (docs/performance.md). Later builds compile only what changed.
BUILD_MINUTES_QUICK=13
BUILD_MINUTES_SLOW=40
build_program() {
    cores=$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)
    if [ ! -e "$built/quadratura" ]; then
        say "building the program: the first time takes $(((BUILD_MINUTES_QUICK + cores - 1) / cores)) to \
$(((BUILD_MINUTES_SLOW + cores - 1) / cores)) minutes on $cores cores; cargo shows its progress"
    fi
    packages='-p quadratura'
    for package in "$@"; do packages="$packages -p $package"; done
    # shellcheck disable=SC2086 # one word each
    cargo build --profile "$profile" $packages
}

check_rust
check_c_compiler
check_vulkan
