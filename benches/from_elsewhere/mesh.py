"""Volume, centre, inertia and convex pieces of meshes beside trimesh.

    run.sh mesh

Shapes of trimesh go through STL (binary and text), OBJ, glTF and GLB into the example `describe` of the crate `mesh`.
Ends with status 1 where volume, centre or inertia differ by more than 1e-6 of the whole, or a point of one side is
farther from the other than the stated deviation.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import ConvexHull

PIECES = 16


def shapes():
    """Names and closed meshes, each turned and moved so that nothing is along an axis."""
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0.1, 0, 0])
    made = {
        "box": trimesh.creation.box([0.3, 0.2, 0.1]),
        "ball": trimesh.creation.icosphere(4, 0.2),
        "cylinder": trimesh.creation.cylinder(0.05, 0.3, sections=48),
        "tube": trimesh.creation.annulus(0.08, 0.1, 0.2),
        "ring": trimesh.creation.torus(0.1, 0.03, 64, 32),
        "capsule": trimesh.creation.capsule(0.2, 0.05),
    }
    for name, mesh in made.items():
        mesh.apply_transform(turn)
        yield name, mesh


def apart(description, mesh, generator):
    """How far sampled points of the solid are from the pieces, and points of pieces from the solid, in metres."""
    hulls = [ConvexHull(np.array(piece["points"])) for piece in description["pieces"]]
    low, high = mesh.bounds
    spread = generator.uniform(low, high, (4000, 3))
    inside = np.vstack([spread[mesh.contains(spread)], mesh.vertices[:2000]])
    # The height above the highest plane is no more than the distance, so this never finds too much.
    heights = [np.max(inside @ hull.equations[:, :3].T + hull.equations[:, 3], axis=1) for hull in hulls]
    lost = float(np.max(np.min(heights, axis=0)))
    added = 0.0
    for hull in hulls:
        weights = generator.dirichlet(np.ones(4), 300)
        corners = hull.points[generator.choice(hull.vertices, (300, 4))]
        points = np.einsum("nk,nkd->nd", weights, corners)
        # Negative outside.
        added = max(added, float(-np.min(trimesh.proximity.signed_distance(mesh, points))))
    return max(lost, 0.0), added


def main():
    describe = sys.argv[1]
    generator = np.random.default_rng(5)
    worst = 0.0
    failed = False
    print("shape     format  triangles  pieces  deviation/mm  lost/mm  added/mm  numbers apart")
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh in shapes():
            for ending in ["stl", "stl_ascii", "obj", "gltf", "glb"]:
                path = Path(folder) / f"{name}.{ending.split('_')[0]}"
                made = trimesh.exchange.export.export_mesh(
                    mesh, None if ending == "gltf" else str(path), file_type=ending
                )
                if ending == "gltf":
                    for file, content in made.items():
                        (Path(folder) / (path.name if file.endswith(".gltf") else file)).write_bytes(content)
                call = subprocess.run(
                    [describe, str(path), "1", str(PIECES)], check=True, capture_output=True, text=True
                )
                found = json.loads(call.stdout)
                inertia = mesh.moment_inertia
                off = max(
                    abs(found["volume"] / mesh.volume - 1),
                    float(np.linalg.norm(found["centre"] - mesh.center_mass)) / mesh.scale,
                    float(np.linalg.norm(np.reshape(found["inertia"], (3, 3)) - inertia) / np.linalg.norm(inertia)),
                )
                worst = max(worst, off)
                lost, added = apart(found, mesh, generator) if ending == "glb" else (0.0, 0.0)
                deviation = found["deviation"]
                failed |= off > 1e-6 or max(lost, added) > deviation + 1e-6
                print(
                    f"{name:9} {ending:9} {found['triangles']:7} {len(found['pieces']):7} {deviation * 1e3:13.4f}"
                    f" {lost * 1e3:8.4f} {added * 1e3:9.4f}  {off:.1e}"
                )
    print(f"volume, centre and inertia are at most {worst:.1e} apart")
    return int(failed)


sys.exit(main())
