# Generators and queues of work: yield, deque-like lists, closures, comprehensions.
def source(count):
    value = 12345
    for _ in range(count):
        value = (value * 1103515245 + 12345) % 2147483648
        yield value


def batches(values, size):
    batch = []
    for value in values:
        batch.append(value)
        if len(batch) == size:
            yield batch
            batch = []
    if batch:
        yield batch


def counter():
    seen = {}

    def add(key):
        seen[key] = seen.get(key, 0) + 1
        return seen[key]
    return add, seen


add, seen = counter()
best = 0
for batch in batches(source(120000), 16):
    low = min(batch)
    best = max(best, add(low % 97))
    picked = [value >> 3 for value in batch if value & 1]
    best += len(set(value % 10 for value in picked)) == 10
print("checksum", best, len(seen), sum(seen.values()), sorted(seen.items())[:3])
