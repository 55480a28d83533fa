#!/bin/sh
# Numbers and toolpaths beside readers and solvers from PyPI, in a virtual environment of their own, and identification
# of many seeded arms.
#     benches/from_elsewhere/run.sh payload        Pinocchio: the payload from the torques of a recording
#     benches/from_elsewhere/run.sh dxf            ezdxf: how far the arm drives from the drawing
#     benches/from_elsewhere/run.sh identify [N]   N seeded runs; needs the wheel, which crates/pybind/test.py builds
#     benches/from_elsewhere/run.sh mesh           trimesh: volume, centre, inertia and convex pieces of meshes
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
eliteserver=${ELITESERVER:-$target/release/eliteserver}
venv="$target/from-elsewhere-venv"
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
what=${1:-payload}
[ $# -gt 0 ] && shift
case "$what" in
payload | dxf)
    "$venv/bin/python" -c 'import pinocchio, ezdxf' 2>/dev/null || "$venv/bin/pip" install --quiet numpy pin ezdxf
    exec "$venv/bin/python" "$here/$what.py" "$eliteserver" "$@"
    ;;
mesh)
    "$venv/bin/python" -c 'import trimesh, scipy, rtree' 2>/dev/null \
        || "$venv/bin/pip" install --quiet trimesh scipy rtree
    (cd "$root" && cargo build --quiet --release -p mesh --example describe)
    exec "$venv/bin/python" "$here/mesh.py" "$target/release/examples/describe" "$@"
    ;;
identify)
    "$venv/bin/python" -c 'import numpy' 2>/dev/null || "$venv/bin/pip" install --quiet numpy
    "$venv/bin/pip" install --quiet --force-reinstall --no-deps "$target"/wheels/elitescript-*.whl
    exec "$venv/bin/python" "$here/identify.py" "$eliteserver" "$@"
    ;;
*)
    echo "run.sh: there is no comparison $what; allowed are payload, dxf, mesh and identify" >&2
    exit 2
    ;;
esac
