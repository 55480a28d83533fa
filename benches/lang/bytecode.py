# A small stack machine: a loop over instructions, methods found by name, frames as objects, a table of jumps.
class Frame:
    def __init__(self, code, back):
        self.code = code
        self.back = back
        self.pc = 0
        self.stack = []
        self.names = {}


class Machine:
    def __init__(self, program):
        self.program = program
        self.frame = Frame(program["main"], None)
        self.steps = 0
        self.table = {name[3:]: getattr(self, name) for name in dir(self) if name.startswith("do_")}

    def do_push(self, value):
        self.frame.stack.append(value)

    def do_load(self, name):
        frame = self.frame
        frame.stack.append(frame.names[name])

    def do_store(self, name):
        frame = self.frame
        frame.names[name] = frame.stack.pop()

    def do_add(self, _):
        stack = self.frame.stack
        right = stack.pop()
        stack[-1] += right

    def do_mul(self, _):
        stack = self.frame.stack
        right = stack.pop()
        stack[-1] = stack[-1] * right % 1000003

    def do_less(self, _):
        stack = self.frame.stack
        right, left = stack.pop(), stack.pop()
        stack.append(left < right)

    def do_jump(self, place):
        self.frame.pc = place

    def do_unless(self, place):
        if not self.frame.stack.pop():
            self.frame.pc = place

    def do_call(self, name):
        argument = self.frame.stack.pop()
        self.frame = Frame(self.program[name], self.frame)
        self.frame.stack.append(argument)

    def do_return(self, _):
        value = self.frame.stack.pop()
        self.frame = self.frame.back
        if self.frame is not None:
            self.frame.stack.append(value)
        return value

    def run(self):
        result = None
        while self.frame is not None:
            frame = self.frame
            name, argument = frame.code[frame.pc]
            frame.pc += 1
            self.steps += 1
            result = self.table[name](argument)
        return result


program = {
    "main": [
        ("push", 0), ("store", "i"), ("push", 1), ("store", "sum"),
        ("load", "i"), ("push", 12000), ("less", None), ("unless", 17),
        ("load", "sum"), ("load", "i"), ("call", "square"), ("add", None), ("store", "sum"),
        ("load", "i"), ("push", 1), ("add", None), ("jump", 20),
        ("load", "sum"), ("return", None), ("push", None),
        ("store", "i"), ("jump", 4),
    ],
    "square": [("store", "x"), ("load", "x"), ("load", "x"), ("mul", None), ("return", None)],
}
machine = Machine(program)
print("checksum", machine.run(), machine.steps)
