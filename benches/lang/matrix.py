# Linear algebra on lists of lists: products, elimination with pivots, transposes, least squares of poses.
def identity(n):
    return [[1.0 if i == j else 0.0 for j in range(n)] for i in range(n)]


def transpose(a):
    return [list(column) for column in zip(*a)]


def product(a, b):
    columns = transpose(b)
    return [[sum(x * y for x, y in zip(row, column)) for column in columns] for row in a]


def solve(a, b):
    n = len(a)
    rows = [list(row) + [value] for row, value in zip(a, b)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            if factor != 0.0:
                for j in range(k, n + 1):
                    rows[i][j] -= factor * rows[k][j]
    x = [0.0] * n
    for i in range(n - 1, -1, -1):
        total = rows[i][n]
        for j in range(i + 1, n):
            total -= rows[i][j] * x[j]
        x[i] = total / rows[i][i]
    return x


def trace(a):
    return sum(a[i][i] for i in range(len(a)))


def sample(n, seed):
    values = []
    for _ in range(n * n):
        seed = (seed * 1103515245 + 12345) & 0x7FFFFFFF
        values.append(seed / 0x7FFFFFFF - 0.5)
    return [values[i * n:(i + 1) * n] for i in range(n)]


total = 0.0
power = identity(12)
for turn in range(12):
    a = sample(12, turn + 1)
    for i in range(12):
        a[i][i] += 4.0
    power = product(power, a)
    scale = max(abs(value) for row in power for value in row)
    power = [[value / scale for value in row] for row in power]
    for k in range(6):
        x = solve(a, [float((i * k + turn) % 5) for i in range(12)])
        total += sum(x)
grid = [[(i * j) % 17 for j in range(120)] for i in range(120)]
flipped = transpose(grid)
same = 0
for i in range(120):
    for j in range(120):
        if grid[i][j] == flipped[i][j] and grid[i][j] > 3:
            same += grid[i][j]
print("checksum", round(total, 6), round(trace(power), 9), same)
