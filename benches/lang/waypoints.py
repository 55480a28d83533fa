# Poses of a pallet: nested lists, float arithmetic, tuples as keys, sorting by distance.
def grid(rows, columns, layers):
    poses = []
    for layer in range(layers):
        for row in range(rows):
            for column in range(columns):
                poses.append([0.3 + 0.05 * column, -0.2 + 0.04 * row, 0.1 + 0.08 * layer, 3.1416, 0.0, 0.1 * (row % 2)])
    return poses


def distance(a, b):
    return ((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2) ** 0.5


poses = grid(40, 50, 20)
home = [0.5, 0.0, 0.4, 3.1416, 0.0, 0.0]
order = sorted(range(len(poses)), key=lambda i: (round(distance(poses[i], home), 3), i))
length = 0.0
for first, second in zip(order, order[1:]):
    length += distance(poses[first], poses[second])
cells = {}
for index, pose in enumerate(poses):
    cell = (int(pose[0] * 10), int(pose[1] * 10), int(pose[2] * 10))
    cells.setdefault(cell, []).append(index)
print("checksum", len(order), round(length, 6), len(cells), max(len(found) for found in cells.values()))
