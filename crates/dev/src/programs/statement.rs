//! Statements that use, change, walk and drop the variables.

use super::Writer;

/// Texts for `exec` and `eval` that nest or repeat; `{}` is how often.
const SHAPES: &[&str] = &[
    "'(' * {} + ')' * {}",
    "'[' * {} + ']' * {}",
    "'-' * {} + '1'",
    "'not ' * {} + '1'",
    "'1' + '+1' * {}",
    "'x' + '.x' * {}",
    "'x' + '()' * {}",
    "'x' + '[0]' * {}",
    "'lambda: ' * {} + '1'",
    "'1 if 1 else ' * {} + '1'",
    "'1' + ' < 1' * {}",
    "'(x := ' * {} + '1' + ')' * {}",
    "'\"a\" ' * {}",
    "'if 1: pass\\n' + 'elif 1: pass\\n' * {}",
    "'@act\\n' * {} + 'def f(): pass'",
    "'f(' * {}",
    "'x = ' * {} + '1'",
    "''.join(' ' * n + 'if 1:\\n' for n in range({})) + ' ' * {} + 'pass'",
    "'def f(' + ''.join('p%d, ' % n for n in range({})) + '): pass'",
    "'global ' + ', '.join('p%d' % n for n in range({}))",
    "'f\"{' * {} + '1' + '}\"' * {}",
    "'x = 1; ' * {}",
    "'{' * {}",
    "'x = \\'' * {}",
    "'print(' + '*a, ' * {} + ')'",
    "'try:\\n pass\\n' + 'except ValueError: pass\\n' * {}",
    "'with ' + 'l, ' * {} + 'l: pass'",
    "'import ' + '.'.join(['os'] * {})",
    "'[' + '1 ' + 'for x in a ' * {} + ']'",
    "'\\\\\\n' * {} + '1'",
];

impl Writer<'_, '_> {
    /// One statement, or a block of them.
    pub(super) fn statement(&mut self, depth: usize) {
        if depth > 2 {
            let expression = self.expression(1);
            return self.guarded(&expression);
        }
        match self.material.below(32) {
            0..=5 => {
                let name = self.variable();
                let line = format!("{}({})", self.method(name), self.arguments(2));
                self.guarded(&line);
            }
            6..=8 => {
                let line = format!("x = {}({})", self.function(), self.arguments(2));
                self.guarded(&line);
            }
            9 | 10 => {
                let line = format!(
                    "{}[{}] = {}",
                    self.variable(),
                    self.index(1),
                    self.expression(2)
                );
                self.guarded(&line);
            }
            11 => {
                let line = format!("del {}[{}]", self.variable(), self.index(1));
                self.guarded(&line);
            }
            12 => {
                let operator = self
                    .material
                    .pick(&["+", "-", "*", "|", "&", "^", "<<", "%", "//", "**", "@"]);
                let line = format!(
                    "{}[{}] {operator}= {}",
                    self.variable(),
                    self.index(1),
                    self.expression(1)
                );
                self.guarded(&line);
            }
            13 => {
                let operator = self
                    .material
                    .pick(&["+", "-", "*", "|", "&", "^", "<<", "%"]);
                let line = format!("{} {operator}= {}", self.variable(), self.expression(2));
                self.guarded(&line);
            }
            14 => {
                let line = format!("{} = {}", self.variable(), self.expression(3));
                self.guarded(&line);
            }
            15 => {
                let line = format!(
                    "{}, *{} = {}",
                    self.variable(),
                    self.variable(),
                    self.expression(2)
                );
                self.guarded(&line);
            }
            16 | 17 => self.walk(depth),
            18 => self.sort(),
            19..=21 => self.walk(depth),
            22 => self.generator(),
            23 => self.attributes(),
            24 => self.raise(depth),
            25 => self.generator(),
            26 => self.threads(),
            27 | 28 => self.sort(),
            29 => self.with(depth),
            30 => {
                let line = format!(
                    "print({}, {}, file=b)",
                    self.expression(2),
                    self.expression(1)
                );
                self.guarded(&line);
            }
            _ => self.compare(),
        }
    }

    fn block(&mut self, head: &str, depth: usize) {
        self.line(head);
        self.indent += 1;
        self.statement(depth + 1);
        self.indent -= 1;
    }

    fn walk(&mut self, depth: usize) {
        self.line("try:");
        self.indent += 1;
        let over = match self.material.below(6) {
            0 => self.variable().to_owned(),
            1 => "d.items()".to_owned(),
            2 => format!("reversed({})", self.variable()),
            3 => format!("enumerate({})", self.variable()),
            4 => format!("zip({}, {})", self.variable(), self.variable()),
            _ => self.expression(2),
        };
        self.line("n = 0");
        let variable = self.material.pick(&["x", "x", "a[0]", "d[K()]", "x, *u"]);
        self.line(&format!("for {variable} in {over}:"));
        self.indent += 1;
        self.line("n += 1");
        self.line("if n > 20: break");
        self.change();
        self.statement(depth + 1);
        self.indent -= 2;
        self.line("except Exception: pass");
    }

    fn sort(&mut self) {
        let keys = [
            "",
            "key=K",
            "key=lambda v: act() or 0",
            "key=act, reverse=True",
            "lambda v, w: act() - 1",
            "key=str",
            "key=functools.cmp_to_key(lambda v, w: act())",
        ];
        let key = self.material.pick(&keys);
        let line = match self.material.below(5) {
            0 => format!("a.sort({key})"),
            1 => format!("a = [K() for _ in range(20)]; a.sort({key})"),
            2 => format!("x = sorted({}, {key})", self.variable()),
            3 => format!("x = max({}, {key})", self.variable()),
            _ => format!("x = min([K(), *a], {key})"),
        };
        self.guarded(&line);
    }

    pub(super) fn grow(&mut self) {
        let growing = [
            "a.append(K())",
            "a += a",
            "a.extend(a)",
            "a[:0] = range(100)",
            "d[count * n] = [n]",
            "d.update({n: K()})",
            "s.add((n, K))",
            "s |= {n * n}",
            "y += y",
            "y.extend(v)",
            "t += t",
            "t = t + str(n)",
            "t = t.replace('a', t)",
            "t = t.join('abc')",
            "t = '%*d' % (n * 1000, 1)",
            "t = format(n, str(n * 1000))",
            "v = v * 2",
            "u += (u, n)",
            "i *= i + 3",
            "i <<= n + 7",
            "i = i ** 3",
            "q.append(q.copy())",
            "x = lambda x=x: x",
            "x = gen(x); next(x)",
            "x = type('C%d' % n, (), {'x': x})",
            "setattr(K, 'attribute%d' % n, n)",
            "hasattr(K, 'attribute%d' % n)",
            "x = (x, [bytearray(n) for _ in range(9)])",
            "x = [x] * n",
            "x = ValueError(x)",
            "w.update([n, 2 ** n])",
            "b.write(str(n) * n)",
            "x = functools.partial(act, x)",
            "x = itertools.chain(x or [], a)",
            "x = map(act, x or a)",
            "x = iter([x])",
            "globals(); exec('p%d = %d' % (n, n))",
            "a.append(threading.Lock())",
            "a.append(collections.namedtuple('N%d' % n, 'a b')(n, a))",
            "a.append(re.compile('a{%d}' % n))",
            "h.put(n, False)",
            "z |= {n}",
            "k[n].append(k)",
            "a.append(a.append)",
            "a.append(range(n, n * n)); list(range(n))",
            "d = dict.fromkeys(range(n * n))",
            "x = list(itertools.product(a[:9], repeat=n % 9))",
            "x = json.dumps([a[:9], t[:99]] * n)",
            "x = struct.pack('%dx' % (n * 1000))",
        ];
        let line = self.material.pick(&growing);
        let other = self.material.pick(&growing);
        let loop_head = self.material.pick(&[
            "while True:",
            "for n in range(30):",
            "for n in range(1000):",
        ]);
        self.line("n = 1");
        self.line("try:");
        self.indent += 1;
        self.line(loop_head);
        self.indent += 1;
        self.line("n += 1");
        self.line(line);
        if self.material.one_in(3) {
            self.line(other);
        }
        self.indent -= 2;
        self.line("except Exception: pass");
    }

    fn attributes(&mut self) {
        let expression = self.expression(1);
        let lines = [
            format!("J.n = {expression}"),
            format!("K.{} = property(act)", self.material.pick(&["n", "__class__", "__iter__", "__eq__"])),
            format!("x = type('T', (J,), {{'n': {expression}, '__slots__': ['z']}})()"),
            format!("x = K(); x.x = x; x.a = {expression}; x.__dict__.clear()"),
            "del K.n".to_owned(),
            format!("setattr({}, 'n', {expression})", self.variable()),
            format!("e.args = {expression}; e.__context__ = e; raise e from e"),
            format!("e.add_note({expression}); e.__notes__.clear(); str(e), repr(e)"),
            format!("isinstance(a, (int, ({expression},), K))"),
            "x = dataclasses.make_dataclass('D', ['a', 'b'])(a, d); dataclasses.asdict(x), x == x, repr(x)".to_owned(),
            format!("x = enum.Enum('E', 'a b'); list(x), x({expression})"),
            "x = contextlib.ExitStack(); x.callback(act); x.push(K()); x.close()".to_owned(),
            "x = super(J, J()); x.n, x.__init__()".to_owned(),
            "vars(K()), dir(K()), K().missing, K.missing".to_owned(),
        ];
        let line = lines[self.material.below(lines.len())].clone();
        self.guarded(&line);
    }

    fn raise(&mut self, depth: usize) {
        self.line("try:");
        self.indent += 1;
        self.block("try:", depth);
        let raised = self.expression(1);
        let error = self.material.pick(&[
            "ValueError(a)",
            "e",
            "ExceptionGroup('e', [e, ValueError()])",
            "KeyError(K()) from e",
            "StopIteration",
            "K",
        ]);
        self.line(&format!("    raise {error}"));
        let caught = self.material.pick(&[
            "Exception",
            "(ValueError, (KeyError,))",
            "BaseException",
            "type(e)",
        ]);
        self.line(&format!("except {caught} as x:"));
        self.line(&format!("    str(x), x.args; {raised}"));
        self.block("finally:", depth);
        self.indent -= 1;
        self.line("except Exception as error: e = error");
    }

    fn generator(&mut self) {
        let lines = [
            "x = gen(); next(x); x = None",
            "x = gen(); next(x); x.throw(ValueError(a))",
            "x = gen(); next(x); x.send(K()); x.close()",
            "x = gen(); a = [x]; next(x); a[:] = []",
            "x = gen(); d[1] = x; next(x); del d[1]",
            "x = [gen() for _ in range(50)]; [next(v) for v in x]; x.clear()",
            "x = gen(); s = {x}; next(x); s.clear()",
            "q = collections.deque([gen()]); next(q[0]); q.clear()",
            "a[0] = gen(); next(a[0]); a[0] = 0",
            "x = gen(); next(x); a[0:1] = [x]; x = 0; a[0:1] = []",
            "x = (yield_ for yield_ in x); next(x)",
            "g = gen(g); next(g); g = gen(g); next(g); list(g)",
            "def h2():\n    try: yield\n    finally: g2.close()\ng2 = h2(); next(g2); g2.close()",
            "d = dict.fromkeys(range(9)); d[1] = gen(); next(d[1]); d.update(d); d = {}",
        ];
        let line = self.material.pick(&lines);
        self.guarded(line);
    }

    fn threads(&mut self) {
        let lines = [
            "x = threading.Thread(target=act); x.start(); x.join(1)",
            "x = [threading.Thread(target=list, args=(map(act, a),)) for _ in range(5)]; [v.start() for v in x]; \
             [v.join(1) for v in x]",
            "x = threading.Thread(target=a.sort, kwargs={'key': lambda v: time.sleep(0.01) or act()}); x.start(); \
             a.clear(); x.join(1)",
            "x = threading.Timer(0.01, act); x.start(); time.sleep(0.02)",
            "x = threading.Thread(target=next, args=(g,)); x.start(); next(g); x.join(1)",
            "x = threading.Condition(); x.acquire(); x.wait(0.01); x.notify_all(); x.release()",
            "x = threading.Barrier(2); threading.Thread(target=x.wait).start(); x.wait(1)",
            "x = threading.local(); x.a = x; x.b = a",
            "h.get(timeout=0.01)",
            "l.acquire(); l.acquire(timeout=0.01)",
        ];
        let line = self.material.pick(&lines);
        self.guarded(line);
    }

    pub(super) fn text_of_program(&mut self) {
        let often = self
            .material
            .pick(&["3", "50", "190", "250", "900", "3000"]);
        let shape = self.material.pick(SHAPES).replace("{}", often);
        // The braces of a text are counted as well; they only make it another text.
        let how = self.material.pick(&[
            "exec({})",
            "eval({})",
            "x = compile({}, 'c', 'exec')",
            "exec({}, d)",
            "x = ({})",
        ]);
        let line = how.replacen("{}", &shape, 1);
        self.guarded(&line);
    }

    fn with(&mut self, depth: usize) {
        self.line("try:");
        self.indent += 1;
        let manager = match self.material.below(4) {
            0 => "K()".to_owned(),
            1 => "contextlib.suppress(Exception)".to_owned(),
            2 => "contextlib.contextmanager(gen)()".to_owned(),
            _ => self.expression(1),
        };
        self.block(&format!("with {manager} as x:"), depth);
        self.indent -= 1;
        self.line("except Exception: pass");
    }

    fn compare(&mut self) {
        let (left, right) = (self.variable(), self.variable());
        let operator = self.material.pick(&["==", "<", ">=", "!=", "in", "-", "|"]);
        let line = match self.material.below(3) {
            0 => format!("x = {left} {operator} {right}"),
            1 => format!("x = [K(), {left}] {operator} [K(), {right}]"),
            _ => format!("x = type({left})({left}) {operator} {left}"),
        };
        self.guarded(&line);
    }
}
