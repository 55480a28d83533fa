"""How far the arm drives from a drawing: ezdxf writes it and says where its curves lie, `eliteserver import` drives it.

    run.sh dxf

The drawing has lines, polylines with bulges, arcs, a circle, an ellipse and a spline in millimetres. Every recorded
position at the height of the work is held against ezdxf's curves, flattened to 0.0005 mm, and every curve against the
positions. Ends with status 1 above 0.05 mm.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import ezdxf
import numpy as np
from ezdxf import path as curves

FRAME = [-0.6, -0.15, 0.25, 0.0, 0.0, 0.0]
AIM_MM = 0.05
FLAT_MM = 0.0005


def drawing(file):
    """Writes the drawing; its curves as ezdxf reads them back, one polyline each, mm."""
    document = ezdxf.new("R2010", units=4)
    space = document.modelspace()
    space.add_lwpolyline(
        [(0, 0, 0), (60, 0, 0.4142), (80, 20, 0), (80, 60, -0.3), (40, 62, 0.2), (0, 60, 0)], "xyb", close=True
    )
    space.add_line((110, 0), (140, 12))
    space.add_line((140, 12), (150, 40))
    space.add_arc((130, 60), 18, 200, 75)
    space.add_circle((35, 30), 15)
    space.add_ellipse((120, 100), (25, 8), 0.45, 0.3, 5.2)
    space.add_open_spline([(0, 90), (15, 110), (35, 85), (60, 105), (80, 95)])
    document.saveas(file)
    read = ezdxf.readfile(file).modelspace()
    return [np.array([[p.x, p.y] for p in curves.make_path(entity).flattening(FLAT_MM)]) for entity in read]


def distances(points, polyline):
    """Of each point from a polyline."""
    nearest = np.full(len(points), np.inf)
    for a, b in zip(polyline[:-1], polyline[1:]):
        along = b - a
        length = along @ along
        if length == 0:
            continue
        part = np.clip((points - a) @ along / length, 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(points - a - part[:, None] * along, axis=1))
    return nearest


def driven(eliteserver, folder):
    """Recorded TCP positions in the frame, mm, with the target pose's."""
    call = lambda *arguments: (
        subprocess.run([eliteserver, *arguments], cwd=folder, check=True, capture_output=True, text=True).stdout
    )
    frame = ",".join(map(str, FRAME))
    # Above the work between the contours, so that rapid moves do not lie in its plane.
    call("import", "a.dxf", f"--frame={frame}", "--lead-in", "0.02", "--check", "--strict", "-o", "a.script")
    call("check", "a.script")
    call("run", "a.script", "--timeout", "600", "--record", "a.mcap")
    rows = list(csv.DictReader(call("replay", "a.mcap", "--csv", "/cycle").splitlines()))
    return [
        np.array([[float(row[f"{name}_tcp_pose_{k}"]) - FRAME[k] for k in range(3)] for row in rows]) * 1e3
        for name in ("actual", "target")
    ]


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        polylines = drawing(folder / "a.dxf")
        worst = {}
        for name, points in zip(("actual", "target"), driven(sys.argv[1], folder)):
            work = points[np.abs(points[:, 2]) < AIM_MM]
            across = np.min([distances(work[:, :2], polyline) for polyline in polylines], axis=0)
            away = np.hypot(across, work[:, 2])
            # The other way round: no part of a curve is left out. Cycles are up to 0.2 mm apart,
            # so the driven points are joined.
            left = max(float(distances(polyline[::5], work[:, :2]).max()) for polyline in polylines)
            worst[name] = max(float(away.max()), left)
            print(
                f"{name}: {len(work)} cycles at work, at most {away.max():.4f} mm from ezdxf's curves; curves at "
                f"most {left:.4f} mm from them"
            )
    print(f"ezdxf {ezdxf.__version__}, {len(polylines)} curves")
    return int(worst["actual"] > AIM_MM)


if __name__ == "__main__":
    sys.exit(main())
