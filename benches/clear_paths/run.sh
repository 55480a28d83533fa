#!/bin/sh
# Compares distances with coal and planned paths with OMPL, both from PyPI, in a virtual environment of their own.
#     benches/clear_paths/run.sh distances [COUNT]
#     benches/clear_paths/run.sh planner [COUNT]
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
venv="$target/clear-paths-venv"
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -c 'import coal, ompl' 2>/dev/null || "$venv/bin/pip" install --quiet numpy coal ompl
what=${1:-distances}
[ $# -gt 0 ] && shift
case "$what" in
distances)
    cargo build --quiet --release --package path-planning --example distances
    exec "$venv/bin/python" "$here/distances.py" "$target/release/examples/distances" "$@"
    ;;
planner)
    exec "$venv/bin/python" "$here/planner.py" "${ELITESERVER:-$target/release/eliteserver}" "$@"
    ;;
*)
    echo "run.sh: there is no comparison $what; allowed are distances and planner" >&2
    exit 2
    ;;
esac
