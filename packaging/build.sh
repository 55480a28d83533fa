#!/usr/bin/env bash
# Makes what is handed out, into target/packages (PACKAGES=FOLDER for another): for each architecture a static program
# with its line tables beside, the wheel, a Debian package; one OCI image layout of all; bills of materials, licences,
# checksums. Made so that the same sources give the same bytes (packaging/test.sh reproduce).
#
#     packaging/build.sh [--arch x86_64|aarch64]... [--only program|deb|image|wheel]... [--quick | --program FILE]
#
# Needs Rust, a C compiler, Python 3 with venv, Node 18 (for the page), and of Debian dpkg-deb, llvm (llvm-objcopy) and,
# for another architecture than this machine's, qemu-user-static. The C compiler and linker for every target is zig,
# from PyPI.
#
# The standard library of a target comes from `rustup target add TARGET`. Where that is not to be had, RUST_LIBRARY
# names the folder `library` of the sources of exactly this compiler, and it is compiled as well (packaging/rust-src.sh
# fetches them on Debian).
#
# --quick leaves out optimisation across crates, --program takes one that is built: for working on these scripts, not
# for handing out.
set -euo pipefail
cd "$(dirname "$0")/.."
root="$PWD"

fail() {
    echo "packaging/build.sh: $*" >&2
    exit 1
}

architectures=()
parts=()
quick=0
given=
while [ $# -gt 0 ]; do
    case "$1" in
    --arch)
        case "${2:-}" in
        x86_64 | aarch64) architectures+=("$2") ;;
        *) fail "--arch ${2:-}: there are packages for x86_64 and aarch64" ;;
        esac
        shift
        ;;
    --only)
        case "${2:-}" in
        program | deb | image | wheel) parts+=("$2") ;;
        *) fail "--only ${2:-}: the parts are program, deb, image and wheel" ;;
        esac
        shift
        ;;
    --quick) quick=1 ;;
    --program)
        given="$(realpath "${2:-}")"
        [ -x "$given" ] || fail "--program ${2:-}: there is no such program"
        shift
        ;;
    *) fail "what is '$1'? --arch ARCHITECTURE, --only PART, --quick, --program FILE" ;;
    esac
    shift
done
host="$(uname -m)"
[ ${#architectures[@]} -gt 0 ] || architectures=("$host")
[ ${#parts[@]} -gt 0 ] || parts=(program deb image wheel)
[ -z "$given" ] || [ ${#architectures[@]} = 1 ] || fail "--program is for one architecture at a time"
has() { [[ " ${parts[*]} " == *" $1 "* ]]; }

version="$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)"
target="${CARGO_TARGET_DIR:-$root/target}"
mkdir -p "$target"
target="$(cd "$target" && pwd)"
# Builds that are handed out share nothing with those of everyday work.
export CARGO_TARGET_DIR="$target/packaging"
packages="${PACKAGES:-$target/packages}"
mkdir -p "$packages" "$CARGO_TARGET_DIR"
packages="$(cd "$packages" && pwd)"
export SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}"
export LC_ALL=C TZ=UTC
umask 022

# Numbers of the oldest C library of GNU that the wheel runs with, as rustc and as Python write it.
glibc=2.28
manylinux=manylinux_2_28

tools="$target/packaging-venv"
[ -x "$tools/bin/python" ] || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check ziglang==0.17.1 cargo-zigbuild==0.24.1 \
    maturin==1.16.0
export PATH="$tools/bin:$PATH"

if [ "$quick" = 1 ]; then
    export CARGO_PROFILE_DIST_LTO=off CARGO_PROFILE_DIST_CODEGEN_UNITS=16
fi

# standard_library TARGET: sets `build_std` to the arguments that cargo needs,
# and to nothing where the target is installed.
standard_library() {
    build_std=()
    local sysroot
    sysroot="$(rustc --print sysroot)"
    [ ! -d "$sysroot/lib/rustlib/$1/lib" ] || return 0
    local library="${RUST_LIBRARY:-$sysroot/lib/rustlib/src/rust/library}"
    [ -f "$library/std/Cargo.toml" ] \
        || fail "the standard library of $1 is not there, and without it nothing can be built for it." \
            "'rustup target add $1' installs it; or RUST_LIBRARY=FOLDER names its sources" \
            "(packaging/rust-src.sh fetches them)"
    # The library has to be this compiler's own; its unstable parts are what the two variables ask for.
    local of release
    release="$(rustc -vV | sed -n 's/^release: //p')"
    of="$release"
    [ ! -f "$library/../src/version" ] || of="$(cat "$library/../src/version")"
    [ "$of" = "$release" ] || fail "$library belongs to Rust $of, the compiler is $release"
    export RUSTC_BOOTSTRAP=1 __CARGO_TESTS_ONLY_SRC_ROOT="$library"
    build_std=(-Zbuild-std=std,panic_unwind)
}

# compile_flags TARGET: no path of this machine gets into a program.
compile_flags() {
    local sources="${CARGO_HOME:-$HOME/.cargo}/registry/src"
    local name="CARGO_TARGET_$(echo "$1" | tr 'a-z-' 'A-Z_')_RUSTFLAGS"
    local flags="--remap-path-prefix=$root=/eliteserver --remap-path-prefix=$CARGO_TARGET_DIR=/target"
    flags="$flags --remap-path-prefix=$sources=/crates --remap-path-prefix=${RUST_LIBRARY:-/nowhere}=/library"
    # zig brings the start-up objects of its C library; an installed target would link those of its own beside them.
    case "$1" in *-musl) flags="$flags -C link-self-contained=no" ;; esac
    export "$name=$flags"
    export CFLAGS="-ffile-prefix-map=$sources=/crates -ffile-prefix-map=$CARGO_TARGET_DIR=/target"
}

# c_library ARCHITECTURE: what zig compiles of the C library at its first use, kept for this build and without line
# tables: they name the folders of the machine, and nobody steps through these functions. What zig finds in its store it
# takes as it is.
c_library() {
    export ZIG_GLOBAL_CACHE_DIR="$CARGO_TARGET_DIR/zig-$1"
    [ ! -f "$ZIG_GLOBAL_CACHE_DIR/stripped" ] || return 0
    rm -rf "$ZIG_GLOBAL_CACHE_DIR"
    # Of other options than those that cargo-zigbuild links with zig would make another one.
    local processor=()
    [ "$1" != x86_64 ] || processor=("-mcpu=$(sed -n 's/.*"target-cpu=\([^"]*\)".*/\1/p' .cargo/config.toml)")
    echo 'int main(void) { return 0; }' >"$CARGO_TARGET_DIR/nothing.c"
    (cd / && python -m ziglang cc -g -fno-sanitize=all "${processor[@]}" -target "$1-linux-musl" \
        "$CARGO_TARGET_DIR/nothing.c" -lunwind -o "$CARGO_TARGET_DIR/nothing")
    find "$ZIG_GLOBAL_CACHE_DIR/o" \( -name 'lib*.a' -o -name '*crt*.o' \) -exec llvm-objcopy --strip-debug {} \;
    touch "$ZIG_GLOBAL_CACHE_DIR/stripped"
}

# program ARCHITECTURE: target/packages/work/ARCHITECTURE with the program, its line tables, pages, completions,
# inventory.
program() {
    local triple="$1-unknown-linux-musl" work="$packages/work/$1"
    local built="${given:-$CARGO_TARGET_DIR/$triple/dist/eliteserver}"
    echo "== the program for $1"
    if [ -z "$given" ]; then
        # Without Node the build goes through and has no page; such a program is not handed out.
        command -v node >/dev/null || fail "the page is bundled by Node (18 or newer), which is not there"
        standard_library "$triple"
        compile_flags "$triple"
        c_library "$1"
        cargo zigbuild --locked --quiet "${build_std[@]}" --target "$triple" --profile dist --package server \
            --bin eliteserver
    fi
    rm -rf "$work"
    mkdir -p "$work/completions"
    # Not compressed: some versions leave bytes of a compressed section's header unset, and the archive packs it anyway.
    llvm-objcopy --only-keep-debug "$built" "$work/eliteserver.debug"
    (cd "$work" && llvm-objcopy --strip-all --add-gnu-debuglink=eliteserver.debug "$built" eliteserver)
    local run=()
    if [ "$1" != "$host" ]; then
        run=("qemu-$1-static")
        command -v "${run[0]}" >/dev/null \
            || fail "to ask the program for $1 for its pages, ${run[0]} is needed (Debian: qemu-user-static)"
    fi
    "${run[@]}" "$work/eliteserver" man "$work/man"
    for shell in bash zsh fish; do
        "${run[@]}" "$work/eliteserver" completions "$shell" >"$work/completions/eliteserver.$shell"
    done
    python3 packaging/inventory.py --package server --target "$triple" --sbom "$work/sbom.cdx.json" \
        --licences "$work/licences.txt"
}

# archive ARCHITECTURE: an archive of the program with what belongs beside it, and its line tables in one of their own.
archive() {
    local name="eliteserver-$version-$1-linux" work="$packages/work/$1"
    local folder="$work/$name"
    mkdir -p "$folder"
    cp -r "$work"/{eliteserver,man,completions,licences.txt,sbom.cdx.json} LICENSE README.md CHANGELOG.md \
        docs/packages.md "$folder"
    pack "$packages/$name.tar.gz" "$work" "$name"
    pack "$packages/$name.debug.tar.gz" "$work" eliteserver.debug
    cp "$work/sbom.cdx.json" "$packages/$name.cdx.json"
}

# pack ARCHIVE FOLDER NAME: in one order, with one date, of one owner.
pack() {
    tar --create --format=gnu --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner \
        --mode=u=rwX,go=rX \
        --directory "$2" "$3" | gzip --no-name -6 >"$1"
}

deb() {
    local work="$packages/work/$1" at="$packages/work/$1/deb" architecture
    case "$1" in x86_64) architecture=amd64 ;; aarch64) architecture=arm64 ;; esac
    echo "== the Debian package for $architecture"
    rm -rf "$at"
    local doc="$at/usr/share/doc/eliteserver"
    install -D -m 755 "$work/eliteserver" "$at/usr/bin/eliteserver"
    install -D -m 644 packaging/debian/eliteserver@.service "$at/usr/lib/systemd/system/eliteserver@.service"
    install -D -m 644 packaging/debian/robot.toml "$at/etc/eliteserver/robot.toml"
    install -D -m 644 "$work/completions/eliteserver.bash" "$at/usr/share/bash-completion/completions/eliteserver"
    install -D -m 644 "$work/completions/eliteserver.zsh" "$at/usr/share/zsh/vendor-completions/_eliteserver"
    install -D -m 644 "$work/completions/eliteserver.fish" "$at/usr/share/fish/vendor_completions.d/eliteserver.fish"
    mkdir -p "$at/usr/share/man/man1" "$doc"
    cp "$work"/man/*.1 "$at/usr/share/man/man1"
    gzip --no-name -9 "$at"/usr/share/man/man1/*.1
    cp docs/packages.md docs/SECURITY.md "$work/sbom.cdx.json" "$doc"
    gzip --no-name -9 --stdout CHANGELOG.md >"$doc/changelog.gz"
    {
        printf 'Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n'
        printf 'Upstream-Name: eliteserver\n\n'
        printf 'Files: *\nCopyright: the authors of eliteserver\nLicense: Apache-2.0\n'
        printf ' The text is in /usr/share/common-licenses/Apache-2.0. Works of others that are linked into the '
        printf 'program,\n with their licences: licences.txt.gz beside this file.\n'
    } >"$doc/copyright"
    gzip --no-name -9 --stdout "$work/licences.txt" >"$doc/licences.txt.gz"
    mkdir "$at/DEBIAN"
    install -m 755 packaging/debian/{postinst,prerm,postrm} "$at/DEBIAN"
    install -m 644 packaging/debian/conffiles "$at/DEBIAN"
    cat >"$at/DEBIAN/control" <<CONTROL
Package: eliteserver
Version: $version
Architecture: $architecture
Maintainer: the authors of eliteserver <eliteserver@localhost>
Installed-Size: $(du -sk --apparent-size "$at" | cut -f1)
Depends: adduser
Recommends: systemd
Section: science
Priority: optional
Description: open controller for Elite Robots CS arms
 Runs EliteScript programs on a simulated arm, serves the vendor's ports
 (programs, interpreter, RTSI, dashboard, Modbus), a pendant page, and
 records every control cycle. Each controller is an instance of the unit
 eliteserver@.service.
CONTROL
    (cd "$at" && find . -type f ! -path './DEBIAN/*' -printf '%P\n' | sort | xargs -d '\n' md5sum) >"$work/md5sums"
    mv "$work/md5sums" "$at/DEBIAN/md5sums"
    find "$at" -print0 | xargs -0 touch --no-dereference --date="@$SOURCE_DATE_EPOCH"
    dpkg-deb --root-owner-group -Zxz -z6 --threads-max=1 --build "$at" \
        "$packages/eliteserver_${version}_$architecture.deb" >/dev/null
}

image() {
    echo "== the OCI image of ${architectures[*]}"
    local programs=() architecture
    for architecture in "${architectures[@]}"; do
        case "$architecture" in
        x86_64) programs+=("amd64=$packages/work/x86_64/eliteserver") ;;
        aarch64) programs+=("arm64=$packages/work/aarch64/eliteserver") ;;
        esac
    done
    rm -rf "$packages/work/oci"
    python3 packaging/image.py --version "$version" --licences "$packages/work/${architectures[0]}/licences.txt" \
        --out "$packages/work/oci" "${programs[@]}"
    tar --create --format=gnu --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner \
        --mode=u=rwX,go=rX \
        --directory "$packages/work/oci" . >"$packages/eliteserver-$version.oci.tar"
}

wheel() {
    local triple="$1-unknown-linux-gnu" work="$packages/work/$1"
    standard_library "$triple"
    compile_flags "$triple"
    export ZIG_GLOBAL_CACHE_DIR="$CARGO_TARGET_DIR/zig-$1"
    echo "== the wheel for $1"
    mkdir -p "$work"
    rm -rf "$work/wheel"
    # One wheel for every CPython from 3.9 on; which one builds it does not show.
    (cd crates/pybind && PYO3_NO_PYTHON=1 maturin build --quiet --locked --profile dist --strip --zig \
        --target "$triple" "${build_std[@]}" --compatibility "$manylinux" --out "$work/wheel")
    # Behind the build, which fetches the libraries of the page.
    python3 packaging/inventory.py --package pybind --target "$triple" --sbom "$work/wheel.cdx.json" \
        --licences "$work/wheel-licences.txt"
    local made=("$work"/wheel/*.whl)
    cp "${made[@]}" "$packages"
    cp "$work/wheel.cdx.json" "$packages/$(basename "${made[0]}" .whl).cdx.json"
}

echo "eliteserver $version of $(date -u -d "@$SOURCE_DATE_EPOCH" +%Y-%m-%d), for ${architectures[*]}: ${parts[*]}"
for architecture in "${architectures[@]}"; do
    if has program || has deb || has image; then
        program "$architecture"
        ! has program || archive "$architecture"
        ! has deb || deb "$architecture"
    fi
    ! has wheel || wheel "$architecture"
done
! has image || image
rm -f "$packages/SHA256SUMS"
(cd "$packages" && find . -maxdepth 1 -type f -printf "%P\n" | sort | xargs sha256sum) >"$target/SHA256SUMS"
mv "$target/SHA256SUMS" "$packages/SHA256SUMS"
echo "== in $packages"
(cd "$packages" && ls -l | awk 'NR > 1 {printf "%10d  %s\n", $5, $9}')
