#!/usr/bin/env bash
# Prints the folder `library` of the sources of the standard library for the compiler in use, fetched from Debian's
# archive into FOLDER. For machines on which `rustup target add` reaches nothing.
#
#     RUST_LIBRARY="$(packaging/rust-src.sh FOLDER)" packaging/build.sh
set -euo pipefail
folder="$(mkdir -p "$1" && cd "$1" && pwd)"
release="$(rustc -vV | sed -n 's/^release: //p')"
library="$folder/usr/src/rustc-$release/library"
if [ ! -d "$library" ]; then
    # A list of packages of its own: what this machine is set up to install stays as it is.
    mkdir -p "$folder/lists/partial" "$folder/cache/archives/partial"
    keys=/usr/share/keyrings/debian-archive-keyring.gpg
    mirror="$(apt-get indextargets --format '$(REPO_URI)' | grep -m 1 '/debian/$')"
    for suite in trixie trixie-backports forky sid; do
        echo "deb [signed-by=$keys] $mirror $suite main"
    done >"$folder/sources.list"
    apt=(-o "Dir::Etc::sourcelist=$folder/sources.list" -o Dir::Etc::sourceparts=/dev/null
        -o "Dir::State::lists=$folder/lists" -o "Dir::Cache=$folder/cache" -o APT::Sandbox::User=root -qq)
    apt-get "${apt[@]}" update >&2
    version="$(apt-cache "${apt[@]}" madison rust-src \
        | awk -F'[ |]+' -v want="$release+" 'index($3, want) == 1 {print $3; exit}')"
    if [ -z "$version" ]; then
        echo "Debian has no rust-src of Rust $release at this time; it has:" >&2
        apt-cache "${apt[@]}" madison rust-src >&2
        exit 1
    fi
    (cd "$folder" && apt-get "${apt[@]}" download "rust-src=$version" >&2)
    # The folder of the library alone: the rest are four hundred megabytes.
    dpkg-deb --fsys-tarfile "$folder"/rust-src_*.deb | tar -x -C "$folder" \
        "./usr/src/rustc-$release/library" "./usr/src/rustc-$release/src/version"
    rm -rf "$folder"/rust-src_*.deb "$folder/lists" "$folder/cache"
fi
echo "$library"
