#!/bin/sh
# Compares distances with coal and planned paths with OMPL, both from PyPI, base poses with a grid, and makes programs
# faster, in a virtual environment of their own. Pinocchio moves the arm.
#     benches/clear_paths/run.sh distances [COUNT]
#     benches/clear_paths/run.sh planner [COUNT] [ROWS.jsonl]
#     benches/clear_paths/run.sh place [COUNT]
#     benches/clear_paths/run.sh optimize
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
venv="$target/clear-paths-venv"
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -c 'import coal, ompl, pinocchio' 2>/dev/null || "$venv/bin/pip" install --quiet numpy coal ompl pin
what=${1:-distances}
[ $# -gt 0 ] && shift
case "$what" in
distances)
    cargo build --quiet --release --package path-planning --example distances
    exec "$venv/bin/python" "$here/distances.py" "$target/release/examples/distances" "$@"
    ;;
planner | place | optimize)
    exec "$venv/bin/python" "$here/$what.py" "${ELITESERVER:-$target/release/eliteserver}" "$@"
    ;;
*)
    echo "run.sh: there is no comparison $what; allowed are distances, planner, place and optimize" >&2
    exit 2
    ;;
esac
