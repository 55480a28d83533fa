# A cell's sequence: classes, dictionaries of bound methods, string states, exceptions on the way.
class Fault(Exception):
    pass


class Station:
    def __init__(self, name, limit):
        self.name = name
        self.limit = limit
        self.state = "idle"
        self.count = 0
        self.faults = 0
        self.steps = {"idle": self.load, "loaded": self.work, "done": self.unload}

    def load(self, part):
        self.part = part
        return "loaded"

    def work(self, part):
        if part % self.limit == 0:
            raise Fault(self.name)
        self.count += part & 3
        return "done"

    def unload(self, part):
        self.part = None
        return "idle"

    def step(self, part):
        try:
            self.state = self.steps[self.state](part)
        except Fault:
            self.faults += 1
            self.state = "idle"


stations = [Station("press", 7), Station("weld", 11), Station("pack", 13)]
for part in range(1, 60001):
    for station in stations:
        station.step(part)
print("checksum", [(s.name, s.count, s.faults, s.state) for s in stations])
