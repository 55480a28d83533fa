# Three axes under PID control with a filter each: small classes, properties, clamping, a log of samples.
class Filter:
    def __init__(self, alpha):
        self.alpha = alpha
        self.value = None

    def __call__(self, sample):
        if self.value is None:
            self.value = sample
        else:
            self.value += self.alpha * (sample - self.value)
        return self.value


class Pid:
    def __init__(self, p, i, d, limit=8.0):
        self.gains = (p, i, d)
        self.limit = limit
        self.integral = 0.0
        self.last = 0.0
        self.smooth = Filter(0.4)

    def step(self, error, dt):
        p, i, d = self.gains
        slope = self.smooth((error - self.last) / dt)
        self.last = error
        out = p * error + i * self.integral + d * slope
        if abs(out) < self.limit:
            self.integral += error * dt
        return max(-self.limit, min(self.limit, out))


class Axis:
    FRICTION = 0.35

    def __init__(self, name, mass, pid):
        self.name, self.mass, self.pid = name, mass, pid
        self.position = self.speed = 0.0
        self.target = 0.0

    @property
    def error(self):
        return self.target - self.position

    def advance(self, dt):
        force = self.pid.step(self.error, dt) - self.FRICTION * self.speed
        self.speed += force / self.mass * dt
        self.position += self.speed * dt
        return self.position


class Plant:
    def __init__(self, axes):
        self.axes = axes
        self.log = []

    def run(self, count, dt=0.004):
        worst = 0.0
        for cycle in range(count):
            if cycle % 500 == 0:
                for number, axis in enumerate(self.axes):
                    axis.target = ((cycle // 500 * 7 + number * 3) % 11) / 10.0
            sample = [axis.advance(dt) for axis in self.axes]
            worst = max(worst, *(abs(axis.error) for axis in self.axes))
            if cycle % 50 == 0:
                self.log.append(tuple(round(value, 4) for value in sample))
        return worst


plant = Plant([
    Axis("x", 1.0, Pid(9.0, 1.5, 2.0)),
    Axis("y", 1.6, Pid(12.0, 1.0, 3.0)),
    Axis("z", 0.7, Pid(6.0, 2.0, 1.2, limit=5.0)),
])
worst = plant.run(12000)
print("checksum", round(worst, 6), len(plant.log), plant.log[-1], round(sum(sum(row) for row in plant.log), 3))
