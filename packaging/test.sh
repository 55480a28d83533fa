#!/usr/bin/env bash
# Installs and uses every package of target/packages (PACKAGES=FOLDER for another) in a fresh place, and says how big
# they are and how long they take to start. Made before by packaging/build.sh.
#
#     packaging/test.sh [PART]...     all of: sums refusals again program deb unit image wheel
#     packaging/test.sh reproduce     builds everything once more, elsewhere, and compares the checksums
#
# Needs root for chroots and namespaces of its own, and of Debian: debootstrap, skopeo, strace, systemd, binutils,
# iproute2.
set -euo pipefail
cd "$(dirname "$0")/.."
root="$PWD"
target="${CARGO_TARGET_DIR:-$root/target}"
packages="$(realpath "${PACKAGES:-$target/packages}")"
version="$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)"
host="$(uname -m)"
passed=0

fail() {
    echo "packaging/test.sh: $*" >&2
    exit 1
}
ok() {
    passed=$((passed + 1))
    echo "   ok: $*"
}
# needs COMMAND PACKAGE: installed where this may install something.
needs() {
    command -v "$1" >/dev/null && return
    [ "$(id -u)" -ne 0 ] || { apt-get update -qq && apt-get install -y -qq "$2" >/dev/null; } || true
    command -v "$1" >/dev/null || fail "$1 is needed (Debian's package $2)"
}
# at_most FILE BYTES: the sizes that are promised.
at_most() {
    local size
    size="$(stat -c %s "$1")"
    [ "$size" -le "$2" ] || fail "$(basename "$1") has $size bytes, at most $2 are promised"
    ok "$(basename "$1") has $size bytes, at most $2"
}

work="$(mktemp -d)"
started=
clean() {
    [ -z "$started" ] || kill "$started" 2>/dev/null || true
    umount -q "$work"/*/proc 2>/dev/null || true
    rm -rf --one-file-system "$work"
}
trap clean EXIT

# started_in FILE COMMAND...: milliseconds until a server that is started so has written its ready file;
# it is then told to end.
started_in() {
    local ready="$1" from to status=0
    shift
    rm -f "$ready"
    from="$(date +%s%N)"
    "$@" 2>"$work/log" &
    started=$!
    until [ -s "$ready" ]; do
        kill -0 "$started" 2>/dev/null || { cat "$work/log" >&2; fail "the server ended before it was ready: $*"; }
        [ $(($(date +%s%N) - from)) -lt 60000000000 ] || fail "the server was not ready within a minute: $*"
        sleep 0.002
    done
    to="$(date +%s%N)"
    kill -TERM "$started"
    wait "$started" || status=$?
    started=
    [ "$status" = 0 ] || { cat "$work/log" >&2; fail "the server ended with $status after SIGTERM: $*"; }
    echo $(((to - from) / 1000000))
}
any_port=(--primary-port 0 --interpreter-port 0 --rtsi-port 0 --dashboard-port 0 --modbus-port 0 --http-port 0)

sums() {
    echo "== checksums and bills of materials"
    (cd "$packages" && sha256sum --quiet --strict --check SHA256SUMS)
    ok "every file has its checksum"
    python3 -m venv "$work/check"
    "$work/check/bin/pip" install --quiet --disable-pip-version-check "cyclonedx-python-lib[json-validation]==11.*"
    "$work/check/bin/python" - "$packages"/*.cdx.json <<'CHECK'
import sys
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

for path in sys.argv[1:]:
    error = JsonStrictValidator(SchemaVersion.V1_5).validate_str(open(path).read())
    if error is not None:
        sys.exit("{}: {}".format(path, error))
CHECK
    ok "the bills of materials are CycloneDX 1.5"
}

refusals() {
    echo "== what the build refuses"
    local said
    said="$(packaging/build.sh --arch sparc 2>&1)" && fail "an architecture that is not there was built"
    [[ "$said" == *"there are packages for x86_64 and aarch64"* ]] || fail "it said: $said"
    ok "an unknown architecture"
    if [ ! -d "$(rustc --print sysroot)/lib/rustlib/aarch64-unknown-linux-musl" ] \
        && [ ! -d "$(rustc --print sysroot)/lib/rustlib/src/rust" ]; then
        said="$(RUST_LIBRARY='' PACKAGES="$work/none" packaging/build.sh --arch aarch64 --only program 2>&1)" \
            && fail "it built without a standard library"
        [[ "$said" == *"rustup target add aarch64-unknown-linux-musl"* ]] || fail "it said: $said"
        ok "a target without its standard library, and how to get it"
    fi
}

# cells_with_parts ARCHITECTURE COMMAND...: records short forms of two cells with parts, and runs again what the
# programs of other architectures have recorded of them before: every number of /cycle and /world must be the same to
# the last bit.
cells_with_parts() {
    local architecture="$1" cell recording
    shift
    mkdir -p "$work/cells"
    sed 's/^columns = 4$/columns = 2/; s/^rows = 3$/rows = 2/; s/^layers = 5$/layers = 1/' \
        examples/cells/palletising/palletise.script >"$work/cells/palletising.script"
    sed 's/^for number in range(5):$/for number in range(2):/' examples/cells/belt/pick.script \
        >"$work/cells/belt.script"
    for cell in palletising belt; do
        recording="$work/cells/$cell-$architecture.mcap"
        "$@" run "$work/cells/$cell.script" --cell "examples/cells/$cell/cell.toml" --record "$recording" \
            >"$work/log" 2>&1 \
            || { cat "$work/log" >&2; fail "the cell $cell does not run"; }
        for recording in "$work/cells/$cell"-*.mcap; do
            [ "$recording" != "$work/cells/$cell-$architecture.mcap" ] || continue
            "$@" replay "$recording" --rerun >"$work/log" 2>&1 \
                || { cat "$work/log" >&2; fail "$architecture runs $(basename "$recording") otherwise"; }
            ok "every cycle and every part of $(basename "$recording") is the same here:" \
                "$(grep -m 1 ^identical "$work/log")"
        done
    done
}

program() {
    needs readelf binutils
    local architecture archive folder run
    for archive in "$packages"/eliteserver-"$version"-*-linux.tar.gz; do
        architecture="$(basename "$archive" -linux.tar.gz)"
        architecture="${architecture##*-}"
        echo "== the program for $architecture"
        tar -x -z -f "$archive" -C "$work"
        folder="$work/eliteserver-$version-$architecture-linux"
        at_most "$folder/eliteserver" 25000000
        ! readelf --program-headers "$folder/eliteserver" | grep -q INTERP \
            || fail "the program asks for a dynamic linker"
        ok "it is static"
        for path in "$root" "${CARGO_HOME:-$HOME/.cargo}" "$target"; do
            ! grep -q -a -F "$path/" "$folder/eliteserver" || fail "the program has the path $path in it"
        done
        ok "no path of this machine is in it"
        run=()
        [ "$architecture" = "$host" ] \
            || { needs "qemu-$architecture-static" qemu-user-static; run=("qemu-$architecture-static"); }
        [ "$("${run[@]}" "$folder/eliteserver" --version)" = "eliteserver $version" ] \
            || fail "it does not tell its version"
        "${run[@]}" "$folder/eliteserver" run examples/first_light.script --record "$work/$architecture.mcap" \
            >/dev/null 2>"$work/log" \
            || { cat "$work/log" >&2; fail "the program does not run first_light"; }
        "${run[@]}" "$folder/eliteserver" replay "$work/$architecture.mcap" | tail -n 3
        ok "first_light runs and is recorded"
        "${run[@]}" "$folder/eliteserver" replay "$work/$architecture.mcap" --csv /cycle \
            >"$work/cycles-$architecture.csv" 2>/dev/null
        "${run[@]}" "$folder/eliteserver" test examples >"$work/log" 2>&1 \
            || { tail -n 40 "$work/log" >&2; fail "tests of examples/ fail"; }
        ok "the tests of examples/: $(tail -n 1 "$work/log")"
        cells_with_parts "$architecture" "${run[@]}" "$folder/eliteserver"
        # The line tables beside it know where its entry is: a function of the module `program`,
        # whichever was not inlined.
        tar -x -z -f "$packages/eliteserver-$version-$architecture-linux.debug.tar.gz" -C "$folder"
        for path in "$root" "${CARGO_HOME:-$HOME/.cargo}" "$target"; do
            ! grep -q -a -F "$path/" "$folder/eliteserver.debug" || fail "the line tables have the path $path in them"
        done
        ok "no path of this machine is in its line tables"
        local main
        main="$(readelf --symbols --wide "$folder/eliteserver.debug" \
            | awk '!found && $4 == "FUNC" && $8 ~ /_6server7program7[a-z]+$/ {print $2; found = 1}')"
        addr2line -e "$folder/eliteserver.debug" "0x$main" | grep -q 'program.rs:' \
            || fail "the line tables do not know $main"
        ok "line tables beside it: $(addr2line -e "$folder/eliteserver.debug" "0x$main")"
        [ -s "$folder/man/eliteserver.1" ] && [ -s "$folder/completions/eliteserver.bash" ] \
            || fail "pages and completions are missing"
        started_in "$work/ready" "${run[@]}" "$folder/eliteserver" serve --record off "${any_port[@]}" \
            --ready-file "$work/ready" >/dev/null
        ok "it serves, and ends when it is told to"
        [ "$architecture" = "$host" ] || continue
        for _ in 1 2 3 4 5; do
            started_in "$work/ready" "$folder/eliteserver" serve --record off "${any_port[@]}" \
                --ready-file "$work/ready"
        done | sort -n | tr '\n' ' ' >"$work/times"
        ok "ready after $(cat "$work/times")ms"
        # Whoever may lock memory holds all of it from then on.
        "$folder/eliteserver" serve --record off "${any_port[@]}" --ready-file "$work/ready" 2>"$work/log" &
        started=$!
        sleep 5
        local held
        held="$(awk '$1 == "VmHWM:" {print $2}' "/proc/$started/status")"
        kill -TERM "$started"
        wait "$started" || true
        started=
        [ "$held" -le 300000 ] || fail "a server holds $held kB of memory"
        ok "a server at rest holds $held kB of memory"
    done
    local first="$work/cycles-$architecture.csv" other
    for other in "$work"/cycles-*.csv; do
        [ "$other" != "$first" ] || continue
        cmp "$first" "$other" || fail "$(basename "$first") and $(basename "$other"), of the same program, differ"
        ok "every cycle of first_light is the same in $(basename "$first" .csv) and $(basename "$other" .csv)"
    done
}

# fresh FOLDER: a minimal Debian, fetched once and copied for every use.
fresh() {
    needs debootstrap debootstrap
    local kept="$target/debian-minimal.tar"
    if [ ! -f "$kept" ]; then
        debootstrap --variant=minbase bookworm "$work/debian" >"$work/log" 2>&1 \
            || { tail -n 5 "$work/log" >&2; fail "debootstrap failed"; }
        tar -c -C "$work/debian" --exclude=./dev/* --exclude=./proc/* --exclude=./sys/* . >"$kept.part"
        mv "$kept.part" "$kept"
        rm -rf "$work/debian"
    fi
    mkdir "$1"
    tar -x -f "$kept" -C "$1"
    mknod -m 666 "$1/dev/null" c 1 3
    mknod -m 666 "$1/dev/urandom" c 1 9
}

deb() {
    echo "== the Debian package"
    local package fresh="$work/root"
    package="$packages/eliteserver_${version}_$(dpkg --print-architecture).deb"
    fresh "$fresh"
    cp "$package" "$fresh/tmp/eliteserver.deb"
    chroot "$fresh" dpkg --install /tmp/eliteserver.deb >/dev/null
    [ "$(chroot "$fresh" dpkg-query -W -f '${Status} ${Version}' eliteserver)" = "install ok installed $version" ] \
        || fail "it is not installed"
    chroot "$fresh" dpkg --verify eliteserver
    ok "dpkg installs it in a minimal Debian, every file as packed"
    local home
    home="$(chroot "$fresh" getent passwd eliteserver | cut -d: -f6,7)"
    [ "$home" = "/var/lib/eliteserver:/usr/sbin/nologin" ] || fail "the user is not there or has $home"
    ok "it has a user of its own"
    local uid gid
    uid="$(chroot "$fresh" id -u eliteserver)" gid="$(chroot "$fresh" id -g eliteserver)"
    install -d -o "$uid" -g "$gid" "$fresh/var/lib/eliteserver/robot"
    local as=(chroot --userspec="$uid:$gid" "$fresh")
    [ "$("${as[@]}" /usr/bin/eliteserver --version)" = "eliteserver $version" ] \
        || fail "the installed program does not answer"
    printf 'sleep(0.1)\nprint("ready")\n' >"$fresh/tmp/a.script"
    [ "$("${as[@]}" /usr/bin/eliteserver run --config /etc/eliteserver/robot.toml /tmp/a.script 2>/dev/null)" \
        = ready ] || fail "it runs no program"
    ok "the installed program runs a script with the configuration of the package"
    local took
    took="$(started_in "$fresh/var/lib/eliteserver/robot/ready" "${as[@]}" /bin/sh -c "cd /var/lib/eliteserver/robot &&
        exec /usr/bin/eliteserver serve --config /etc/eliteserver/robot.toml --ready-file ready ${any_port[*]}")"
    ls "$fresh"/var/lib/eliteserver/robot/recordings/*.mcap >/dev/null || fail "it has recorded nothing"
    ok "it serves as its own user, ready after $took ms, and records into /var/lib/eliteserver/robot"
    [ -f "$fresh/usr/share/man/man1/eliteserver-doctor.1.gz" ] || chroot "$fresh" dpkg -L eliteserver \
        | grep -q eliteserver-doctor.1.gz \
        || fail "no manual pages"
    bash -c "source '$fresh/usr/share/bash-completion/completions/eliteserver' && complete -p eliteserver" >/dev/null \
        || fail "bash cannot complete it"
    ok "manual pages and completions"
    echo "# mine" >>"$fresh/etc/eliteserver/robot.toml"
    chroot "$fresh" dpkg --install --force-confold /tmp/eliteserver.deb >/dev/null
    grep -q '^# mine' "$fresh/etc/eliteserver/robot.toml" || fail "installing again lost the configuration"
    chroot "$fresh" dpkg --remove eliteserver >/dev/null
    [ ! -e "$fresh/usr/bin/eliteserver" ] && [ -e "$fresh/etc/eliteserver/robot.toml" ] \
        || fail "removing it removed the wrong things"
    chroot "$fresh" dpkg --purge eliteserver >/dev/null 2>&1
    [ ! -e "$fresh/etc/eliteserver" ] && ls "$fresh"/var/lib/eliteserver/robot/recordings/*.mcap >/dev/null \
        || fail "purging it"
    ok "installed again, removed and purged: the configuration goes last, recordings stay"
    rm -rf --one-file-system "$fresh"
}

unit() {
    needs systemd-analyze systemd
    needs strace strace
    echo "== the unit"
    local fresh="$work/unit" name=eliteserver@robot.service
    mkdir "$fresh"
    dpkg-deb --extract "$packages/eliteserver_${version}_$(dpkg --print-architecture).deb" "$fresh"
    mkdir -p "$fresh/etc/systemd/system"
    # Targets and slices that the unit refers to are those of this machine.
    cp -r /usr/lib/systemd/system/*.target /usr/lib/systemd/system/*.slice "$fresh/usr/lib/systemd/system/"
    systemd-analyze verify --man=no --root="$fresh" "$name" 2>"$work/said" \
        || { cat "$work/said" >&2; fail "systemd-analyze verify"; }
    ! grep -i "eliteserver" "$work/said" || fail "systemd-analyze has something to say"
    ok "systemd-analyze verify has nothing to say"
    local score
    score="$(systemd-analyze security --no-pager --offline=true --root="$fresh" "$name" \
        | sed -n 's/.*Overall exposure level.*: \([0-9.]*\) .*/\1/p')"
    awk -v score="$score" 'BEGIN {exit !(score != "" && score <= 2)}' \
        || fail "the exposure is '$score', at most 2 is promised"
    ok "systemd-analyze security: exposure $score (0 is none, 10 all)"

    # What the sandbox allows is compared with what the program does: while it serves,
    # and while programs use what they may.
    local allowed="$work/allowed" program="$fresh/usr/bin/eliteserver"
    list() { systemd-analyze syscall-filter --no-pager "$1" | awk '/^ +@/ {print $1} /^ +[a-z_0-9]+$/ {print $1}' \
        | while read -r word; do
        case "$word" in "$1") ;; @*) list "$word" ;; *) echo "$word" ;; esac
    done; }
    list @system-service | sort -u >"$work/service"
    { list @privileged; list @keyring; } | sort -u >"$work/denied"
    comm -23 "$work/service" "$work/denied" >"$allowed"
    list @default | sort -u | sort -u - "$allowed" -o "$allowed"
    (cd "$work" && timeout -s TERM 4 strace -f -qq -o "$work/served" "$program" serve \
        --record "$work/served.mcap" "${any_port[@]}" 2>/dev/null) || true
    printf '%s\n' 'import time' 'f = socket_open("127.0.0.1", 9)' 'movej(get_actual_joint_positions(), a=1, v=1)' \
        'print(sum([i for i in range(100000)]))' >"$work/a.script"
    (cd "$work" && strace -f -qq -o "$work/ran" "$program" run a.script --record "$work/ran.mcap" >/dev/null 2>&1) \
        || true
    [ "$(wc -l <"$work/served")" -gt 1000 ] && [ "$(wc -l <"$work/ran")" -gt 300 ] || fail "strace has seen too little"
    sed -nE 's/^[0-9]+ +(<\.\.\. )?([a-z_0-9]+)[ (].*/\2/p' "$work/served" "$work/ran" | sort -u >"$work/used"
    comm -23 "$work/used" "$allowed" | grep -v '^execve$' >"$work/missing" || true
    [ ! -s "$work/missing" ] || fail "the sandbox refuses what the program does: $(tr '\n' ' ' <"$work/missing")"
    grep -q sched_setscheduler "$work/used" && grep -q mlockall "$work/used" \
        || fail "it asked for no priority or locked no memory"
    ok "the $(wc -l <"$work/used") system calls of a server and a program are allowed," \
        "priority and locked memory among them"
    ! grep -E '(mmap|mprotect)\(.*PROT_WRITE\|PROT_EXEC' "$work/served" "$work/ran" \
        || fail "memory that is written and executed"
    ok "no memory is writable and executable"
    ! grep -oE 'socket\(AF_[A-Z0-9]+' "$work/served" "$work/ran" | grep -vE 'AF_(UNIX|INET|INET6)$' \
        || fail "an address family that the unit refuses"
    ok "no address family beyond AF_INET, AF_INET6, AF_UNIX"
}

image() {
    needs skopeo skopeo
    needs ip iproute2
    echo "== the OCI image"
    local archive="$packages/eliteserver-$version.oci.tar" at="$work/image" fresh="$work/container"
    case "$host" in x86_64) architecture=amd64 ;; aarch64) architecture=arm64 ;; esac
    skopeo --override-os linux --override-arch "$architecture" inspect "oci-archive:$archive:$version" \
        >"$work/inspected"
    skopeo --override-os linux --override-arch "$architecture" copy --quiet "oci-archive:$archive:$version" "dir:$at"
    ok "skopeo reads it and takes it apart, every digest as it says"
    mkdir "$fresh"
    python3 - "$at" "$fresh" >"$work/command" <<'TAKE'
import json, sys, tarfile
from pathlib import Path

image, fresh = map(Path, sys.argv[1:])
manifest = json.loads((image / "manifest.json").read_text())
blob = lambda entry: image / entry["digest"].partition(":")[2]
config = json.loads(blob(manifest["config"]).read_text())["config"]
for layer in manifest["layers"]:
    with tarfile.open(blob(layer)) as tar:
        tar.extractall(fresh, numeric_owner=True)
print(config["User"])
print(config["WorkingDir"])
print(" ".join(config["Entrypoint"] + config["Cmd"]))
TAKE
    local user folder command
    { read -r user; read -r folder; read -r command; } <"$work/command"
    [ "${user%%:*}" != 0 ] && [ "${user%%:*}" != root ] || fail "the image runs as root"
    [ "$(find "$fresh" -type f -perm /111 | wc -l)" = 1 ] || fail "there is more than one program in it"
    # The devices that every engine gives a container.
    mkdir "$fresh/dev"
    mknod -m 666 "$fresh/dev/null" c 1 3
    mknod -m 666 "$fresh/dev/urandom" c 1 9
    # A network of its own, where the vendor's ports are free; nothing of this machine but its kernel.
    cat >"$work/inside" <<INSIDE
set -e
ip link set lo up
start() { exec chroot --userspec=$user '$fresh' "\$@"; }
cd /
(start $command --ready-file $folder/ready) 2>'$work/log' &
server=\$!
chroot --userspec=$user '$fresh' /usr/bin/eliteserver wait --port 30001 --timeout 30
grep '^Uid:' /proc/\$server/status
printf 'sleep(0.05)\n' >'$fresh/tmp/a.script'
chroot --userspec=$user '$fresh' /usr/bin/eliteserver send /tmp/a.script
kill -TERM \$server
wait \$server
INSIDE
    # An engine starts the command in its working directory; chroot starts it in /, so recordings are named.
    command="$command --record $folder/recording.mcap"
    sed -i "s|(start .*|(start $command --ready-file $folder/ready) 2>'$work/log' \&|" "$work/inside"
    unshare --net --fork bash "$work/inside" >"$work/said" 2>&1 \
        || { cat "$work/said" "$work/log" >&2; fail "the image does not run"; }
    grep -q "^Uid:[[:space:]]*${user%%:*}[[:space:]]" "$work/said" \
        || { cat "$work/said" >&2; fail "it runs as another user"; }
    [ -s "$fresh$folder/recording.mcap" ] || fail "it has recorded nothing"
    ok "started without an engine as user ${user%%:*}, served a program on the vendor's port," \
        "ended with everything flushed"
}

# A program on a controller of its own: what the module must do in whichever Python.
use_module='
import elitescript

result = elitescript.Controller().run("movej([0, -1.2, 1.2, -1.57, -1.57, 0], a=1, v=1)\nprint(6 * 7)\n")
assert result.outcome == "ended" and result.prints == ["42"], result
'
wheel() {
    local made architecture path found=0
    for made in "$packages"/elitescript-"$version"-*.whl; do
        [ -f "$made" ] || continue
        case "$made" in
        *_x86_64.whl) architecture=x86_64 ;;
        *_aarch64.whl) architecture=aarch64 ;;
        *) fail "for which machines is $(basename "$made")?" ;;
        esac
        echo "== the wheel for $architecture"
        at_most "$made" 15000000
        rm -rf "$work/unpacked"
        python3 -m zipfile --extract "$made" "$work/unpacked"
        for path in "$root" "${CARGO_HOME:-$HOME/.cargo}" "$target"; do
            ! grep -q -r -a -F "$path/" "$work/unpacked" || fail "the wheel has the path $path in it"
        done
        ok "no path of this machine is in it"
        if [ "$architecture" = "$host" ]; then
            found=1
            wheel_here "$made"
        else
            wheel_elsewhere "$made" "$architecture"
        fi
        "$work/fresh/bin/pip" install --quiet --disable-pip-version-check auditwheel
        "$work/fresh/bin/python" -m auditwheel show "$made" >"$work/log" 2>&1 \
            || { cat "$work/log" >&2; fail "auditwheel does not read it"; }
        tr '\n' ' ' <"$work/log" | grep -oE 'consistent with the following platform tag: "[^"]*"' \
            || { cat "$work/log" >&2; fail "auditwheel: no tag"; }
        ok "auditwheel agrees with its tag"
    done
    [ "$found" = 1 ] || fail "there is no wheel for $host in $packages"
    local first="$work/wheel-cycles-$host.csv" other
    for other in "$work"/wheel-cycles-*.csv; do
        [ "$other" != "$first" ] || continue
        cmp "$first" "$other" || fail "$(basename "$first") and $(basename "$other"), of the same program, differ"
        ok "every cycle of first_light is the same in $(basename "$first" .csv) and $(basename "$other" .csv)"
    done
}
wheel_here() {
    [ -x "$work/fresh/bin/python" ] || python3 -m venv "$work/fresh"
    local bin="$work/fresh/bin"
    "$bin/pip" install --quiet --disable-pip-version-check "$1"
    "$bin/pip" check
    [ "$("$bin/eliteserver" --version)" = "eliteserver $version" ] || fail "the command is not there"
    ok "pip installs it in a fresh environment; the command answers"
    (cd "$work" && "$bin/python" -c "$use_module")
    ok "the module runs a program on a controller of its own"
    cycles_of_wheel "$host" "$bin/eliteserver"
    for _ in 1 2 3; do
        started_in "$work/ready" "$bin/eliteserver" serve --record off "${any_port[@]}" --ready-file "$work/ready"
    done | sort -n | tr '\n' ' ' >"$work/times"
    ok "its command is ready after $(cat "$work/times")ms"
}
# cycles_of_wheel ARCHITECTURE COMMAND...: what its command records.
cycles_of_wheel() {
    local architecture="$1"
    shift
    "$@" run examples/first_light.script --record "$work/$architecture.mcap" >/dev/null 2>"$work/log" \
        || { cat "$work/log" >&2; fail "its command does not run first_light"; }
    "$@" replay "$work/$architecture.mcap" --csv /cycle >"$work/wheel-cycles-$architecture.csv" 2>"$work/log"
    ok "its command runs first_light and records $(($(wc -l <"$work/wheel-cycles-$architecture.csv") - 1)) cycles"
}
# wheel_elsewhere WHEEL ARCHITECTURE: installed by pip as on a machine of that kind, and used by Debian's Python of that
# kind under qemu.
wheel_elsewhere() {
    local debian folder="$work/$2-debian" packed python
    case "$2" in x86_64) debian=amd64 ;; aarch64) debian=arm64 ;; esac
    needs "qemu-$2-static" qemu-user-static
    needs debootstrap debootstrap
    [ -x "$work/fresh/bin/python" ] || python3 -m venv "$work/fresh"
    # Its packages are only unpacked: nothing of them could be started here without qemu.
    debootstrap --foreign --arch="$debian" --variant=minbase --include=python3 bookworm "$folder" >"$work/log" 2>&1 \
        || { tail -n 5 "$work/log" >&2; fail "debootstrap failed"; }
    for packed in "$folder"/var/cache/apt/archives/*.deb; do dpkg-deb --extract "$packed" "$folder"; done
    "$work/fresh/bin/pip" install --quiet --disable-pip-version-check --target "$work/$2-packages" --only-binary :all: \
        --implementation cp --python-version 3.11 --abi cp311 --abi abi3 \
        --platform "manylinux_2_28_$2" --platform "manylinux_2_27_$2" --platform "manylinux2014_$2" "$1"
    ok "pip installs it, and what it needs, as for such a machine"
    python=(env PYTHONPATH="$work/$2-packages" PYTHONDONTWRITEBYTECODE=1
        "qemu-$2-static" -L "$folder" "$folder/usr/bin/python3.11")
    (cd "$work" && "${python[@]}" -c "$use_module")
    ok "the module runs a program on a controller of its own"
    local command='import sys; from elitescript._command import main; main()'
    [ "$("${python[@]}" -c "$command" --version)" = "eliteserver $version" ] \
        || fail "its command does not tell its version"
    cycles_of_wheel "$2" "${python[@]}" -c "$command"
    started_in "$work/ready" "${python[@]}" -c "$command" serve --record off "${any_port[@]}" \
        --ready-file "$work/ready" >/dev/null
    ok "its command serves, and ends when it is told to"
    rm -rf --one-file-system "$folder"
}

again() {
    echo "== everything but the compiler, twice from one program, under other circumstances"
    local given="${PROGRAM:-$packages/work/$host/eliteserver}" files
    [ -x "$given" ] || fail "there is no program $given: packaging/build.sh makes it, or PROGRAM=FILE names one"
    # The date of the sources, whatever is committed meanwhile.
    export SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct)}"
    PACKAGES="$work/first" packaging/build.sh --program "$given" --only program --only deb --only image \
        >"$work/log" 2>&1 \
        || { cat "$work/log" >&2; fail "the packages were not made"; }
    # Another folder, another second, other habits of whoever builds.
    (umask 077 && TZ=Asia/Shanghai LC_ALL=C.UTF-8 PACKAGES="$work/second/elsewhere" \
        packaging/build.sh --program "$given" --only program --only deb --only image >"$work/log" 2>&1) \
        || { cat "$work/log" >&2; fail "the packages were not made again"; }
    files="$(wc -l <"$work/first/SHA256SUMS")"
    [ "$files" -ge 5 ] || fail "only $files files were made"
    diff "$work/first/SHA256SUMS" "$work/second/elsewhere/SHA256SUMS" || fail "the same program gave other packages"
    ok "$files files, the same bytes twice"
}

reproduce() {
    echo "== the same sources, once more, in another folder"
    git clone --quiet --no-hardlinks "$root" "$work/again"
    local arguments=()
    for archive in "$packages"/eliteserver-"$version"-*-linux.tar.gz; do
        archive="$(basename "$archive" -linux.tar.gz)"
        arguments+=(--arch "${archive##*-}")
    done
    ls "$packages"/*.whl >/dev/null 2>&1 || arguments+=(--only program --only deb --only image)
    [ -z "${PACKAGES_QUICK:-}" ] || arguments+=(--quick)
    (cd "$work/again" && CARGO_TARGET_DIR="$work/again-target" PACKAGES="$work/again-packages" \
        packaging/build.sh "${arguments[@]}")
    diff "$packages/SHA256SUMS" "$work/again-packages/SHA256SUMS" || {
        rm -rf "$target/packages-again"
        mv "$work/again-packages" "$target/packages-again"
        fail "the second build gave other bytes; it is in $target/packages-again"
    }
    ok "the second build gave the same bytes"
}

[ $# -gt 0 ] || set -- sums refusals again program deb unit image wheel
for part in "$@"; do
    case "$part" in
    sums | refusals | again | program | deb | unit | image | wheel | reproduce) "$part" ;;
    *) fail "what is '$part'? sums, refusals, again, program, deb, unit, image, wheel, reproduce" ;;
    esac
done
echo "$passed passed, 0 failed"
