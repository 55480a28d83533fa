//! A stop reaches what never ends by itself: natives that are given endless iterators, and work whose size is a number
//! that anybody can write. Between two safepoints there are a few milliseconds at most, and a stop ends the program.
//!
//! Functions are those of the builtins and of the library that `dir` finds, methods those of a value of every type.
#![allow(clippy::unwrap_used, clippy::expect_used)] // a test

use std::sync::mpsc;
use std::time::Duration;

use elite_lang::Limits;

use crate::stretch::{STRETCH_MAX, TRIES, longest};
use crate::support::Task;

/// What has not come to a safepoint after this long never will.
const SILENCE_MAX: Duration = Duration::from_secs(60);

/// Iterators without an end. What they yield is refused by some natives, is nothing for others, and grows in none that
/// drop it.
const ENDLESS: &[&str] = &[
    "itertools.repeat('')",
    "itertools.repeat((1, 2))",
    "itertools.count()",
    "forever()",
    "Items()",
    "map(abs, itertools.repeat(0))",
    "itertools.repeat(b'')",
    "itertools.cycle([[]])",
];

/// How a function gets one. What is made step by step is asked for the next value, twice.
const FORMS: &[&str] = &[
    "asked(f(e()))",
    "asked(f(e(), 1))",
    "asked(f(1, e()))",
    "asked(f('', e()))",
    "asked(f(e(), e()))",
    "asked(f(no, e()))",
    "asked(f(pair, e()))",
    "asked(f([], e()))",
    "asked(f(e(), key=no))",
];

/// What has methods.
const RECEIVERS: &[&str] = &[
    "''",
    "'a'",
    "b''",
    "bytearray(b'a')",
    "[1]",
    "(1,)",
    "{1: 1}",
    "{1: 1}.keys()",
    "{1: 1}.items()",
    "{1}",
    "frozenset([1])",
    "range(3)",
    "collections.deque([1], 3)",
    "collections.OrderedDict(a=1)",
    "collections.Counter('a')",
    "collections.defaultdict(list)",
    "collections.ChainMap({})",
    "collections.UserList([1])",
    "collections.UserDict(a=1)",
    "io.StringIO()",
    "io.BytesIO()",
    "re.compile('a')",
    "1",
    "0.5",
    "random.Random(1)",
    "struct.Struct('i')",
    "string.Formatter()",
];

/// What is no call of a function with an iterator, and never ends or takes a number of somebody's choice.
const ACTS: &[&str] = &[
    "a, b = e()",
    "a, *b = e()",
    "[*e()]",
    "{*e()}",
    "2 in e()",
    "no in map(no, e())",
    "x = [1]; x[:] = e()",
    "x = [1]; x[::2] = e()",
    "x = bytearray(9); x[:] = e()",
    "x = [1]; x += e()",
    "x = {1}; x |= set(e())",
    "next(itertools.chain.from_iterable(itertools.repeat(())))",
    "next(itertools.chain.from_iterable(itertools.repeat('')))",
    "next(filter(None, itertools.repeat(0)))",
    "next(filter(no, e()))",
    "next(itertools.filterfalse(None, itertools.repeat(1)))",
    "next(itertools.dropwhile(bool, itertools.repeat(1)))",
    "next(itertools.compress(itertools.repeat(1), itertools.repeat(0)))",
    "g = itertools.groupby(itertools.repeat(1)); next(g); next(g)",
    "next(itertools.islice(e(), 10 ** 15, None))",
    "x, y = itertools.tee(e()); next(itertools.islice(x, 10 ** 15, None))",
    "next(itertools.islice(itertools.accumulate(itertools.repeat(0)), 10 ** 15, None))",
    "collections.deque(e(), 0)",
    "sum(range(10 ** 12))",
    "max(range(10 ** 12))",
    "min(range(10 ** 12))",
    "sorted(range(10 ** 12))",
    "all(range(1, 10 ** 12))",
    "any(itertools.repeat(0))",
    "1.5 in range(10 ** 12)",
    "range(10 ** 12).count(no)",
    "range(10 ** 12).index(1.5)",
    "range(10 ** 12) == list(range(100))",
    "tuple(range(10 ** 12))",
    "set(range(10 ** 12))",
    "dict.fromkeys(range(10 ** 12))",
    "collections.Counter(itertools.repeat(1))",
    "bytes(itertools.repeat(1))",
    "3 ** 10 ** 8",
    "pow(3, 10 ** 8)",
    "pow(3, 10 ** 6, 10 ** 20000 + 1)",
    "pow(3, -1, 10 ** 20000 + 1)",
    "10 ** 10 ** 10",
    "(1 << 4000000) * ((1 << 4000000) - 1)",
    "((1 << 4000000) - 1) // ((1 << 2000000) + 1)",
    "((1 << 4000000) - 1) % ((1 << 2000000) + 1)",
    "math.gcd((1 << 400000) - 1, (1 << 399999) + 1)",
    "math.lcm(*range(1, 100000))",
    "math.factorial(10 ** 6)",
    "math.factorial(10 ** 12)",
    "math.comb(10 ** 6, 5 * 10 ** 5)",
    "math.comb(10 ** 12, 5 * 10 ** 11)",
    "math.perm(10 ** 7)",
    "math.isqrt(1 << 10 ** 7)",
    "math.prod(range(1, 10 ** 9))",
    "math.nextafter(0.0, 1.0, steps=10 ** 18)",
    "math.ldexp(1.0, 10 ** 15)",
    "round(1, -10 ** 12)",
    "round(10 ** 4000, -10 ** 9)",
    "round(1.5, 10 ** 9)",
    "1 << 10 ** 12",
    "(-1) >> 10 ** 12",
    "str(1 << 10 ** 7)",
    "f'{1 << 4000000}'",
    "hex(1 << 10 ** 7)",
    "bin((1 << 10 ** 7) - 1)",
    "f'{(1 << 4000000):_b}'",
    "'%x' % (1 << 10 ** 7)",
    "int('1' * 10 ** 6)",
    "int('f' * 10 ** 6, 16)",
    "int('z' * 10 ** 6, 36)",
    "float('1' * 10 ** 6)",
    "float('0.' + '1' * 10 ** 6)",
    "float.fromhex('0x' + '1' * 10 ** 6)",
    "hash(1 << 10 ** 7)",
    "'a' * 10 ** 12",
    "'a' * 10 ** 7",
    "[0] * 10 ** 12",
    "[0] * 10 ** 7",
    "(0, 1) * 10 ** 6",
    "bytes(10 ** 12)",
    "bytearray(10 ** 7)",
    "x = [0]; x *= 10 ** 12",
    "collections.deque([0]) * 10 ** 12",
    "collections.deque([0, 1], 3) * 10 ** 12",
    "collections.deque(range(9)).rotate(10 ** 15)",
    "'a'.ljust(10 ** 12)",
    "'a'.zfill(10 ** 7)",
    "'\\t'.expandtabs(10 ** 12)",
    "('\\t' * 1000).expandtabs(10 ** 5)",
    "f'{1:1000000000}'",
    "f'{1.5:.1000000f}'",
    "f'{1.5:1000000000.3f}'",
    "'%1000000000d' % 1",
    "'%.1000000f' % 1.5",
    "'%.1000000000d' % 1",
    "('{0:{0}}' * 1000).format(10 ** 5)",
    "'a'.replace('', 'b' * 10 ** 6)",
    "('a' * 10 ** 4).replace('', 'b' * 10 ** 4)",
    "('a' * 10 ** 6).find('a' * (5 * 10 ** 5) + 'b')",
    "('a' * 10 ** 6).rfind('b' + 'a' * (5 * 10 ** 5))",
    "('a' * 10 ** 6).count('a' * (5 * 10 ** 5) + 'b')",
    "('ab' * 10 ** 6).split('a')",
    "struct.pack('%dx' % 10 ** 7)",
    "struct.calcsize('1000000000000000000000x')",
    "struct.pack('b' * 10 ** 5, *([1] * 10 ** 5))",
    "list(struct.iter_unpack('b', bytes(10 ** 6)))",
    "int.from_bytes(bytes(10 ** 6) + b'1')",
    "(1 << 10 ** 6).to_bytes(10 ** 7)",
    "(1).to_bytes(10 ** 12)",
    "next(itertools.product(range(10 ** 12)))",
    "next(itertools.product('ab', repeat=10 ** 12))",
    "next(itertools.product('ab', repeat=10 ** 6))",
    "[0 for _ in itertools.product(range(1000), repeat=9)]",
    "all(itertools.product([1], repeat=3))",
    "next(itertools.combinations(range(10 ** 12), 2))",
    "next(itertools.combinations(range(10 ** 6), 5 * 10 ** 5))",
    "next(itertools.permutations(range(10 ** 6)))",
    "next(itertools.permutations(range(10 ** 12), 2))",
    "next(itertools.combinations_with_replacement('ab', 10 ** 12))",
    "next(itertools.combinations_with_replacement('ab', 10 ** 6))",
    "collections.deque(itertools.permutations(range(12)), 0)",
    "collections.deque(itertools.combinations(range(60), 30), 0)",
    "collections.deque(itertools.repeat(0, 10 ** 12), 0)",
    "itertools.tee([], 10 ** 12)",
    "itertools.tee([], 10 ** 6)",
    "next(itertools.batched(e(), 10 ** 12))",
    "next(zip(*[iter('a')] * 10 ** 6))",
    "print(*e())",
    "pair(*e())",
    "pair(**{str(v): v for v in range(10 ** 5)})",
    "re.match('(a*)*b', 'a' * 40)",
    "re.match('(a|a)*b', 'a' * 40)",
    "re.match('(a|aa)+$', 'a' * 60 + 'b')",
    "re.search('(x+x+)+y', 'x' * 60)",
    "re.fullmatch('(?:(?:a?)*)*b', 'a' * 60)",
    "re.findall('(?=(a+))b', 'a' * 10 ** 5)",
    "re.sub('(?:a+a+)+b', '', 'a' * 60)",
    "re.split('(a+)+b', 'a' * 60)",
    "re.match(r'(a*)\\1*b', 'a' * 10 ** 4)",
    "re.match('(?<=a)*b', 'a' * 10 ** 4)",
    "re.compile('(?:a{1000}){1000}')",
    "re.match('(?:(?:a{0,1000}){0,1000}){0,1000}b', 'a' * 1000)",
    "re.compile('[a-z]' * 10 ** 5)",
    "re.compile('|'.join('a%d' % v for v in range(10 ** 4)))",
    "re.match('((((((a*)*)*)*)*)*)*b', 'a' * 30)",
    "re.sub('', 'b' * 10 ** 4, 'a' * 10 ** 4)",
    "random.sample(range(10 ** 12), 10 ** 9)",
    "random.choices(range(10), k=10 ** 12)",
    "random.getrandbits(10 ** 7)",
    "random.randint(0, 1 << 10 ** 6)",
    "random.seed('a' * 10 ** 6)",
    "random.shuffle(list(range(10 ** 5)))",
    "statistics.mean(e())",
    "statistics.median(range(10 ** 12))",
    "heapq.nlargest(1, e())",
    "heapq.nsmallest(10 ** 12, e())",
    "list(heapq.merge(e(), e()))",
    "functools.reduce(max, e())",
    "datetime.timedelta(1) * 10 ** 4000",
    "datetime.date(1, 1, 1).strftime('%Y' * 10 ** 6)",
    "string.Template('$a' * 10 ** 5).substitute(a='')",
    "json.loads('[' + '1,' * 10 ** 5 + '1]')",
    "json.dumps(list(range(10 ** 5)))",
    "copy.deepcopy(list(range(10 ** 5)))",
    "enum.Enum('E', e())",
    "collections.namedtuple('N', e())",
    "dataclasses.make_dataclass('D', e())",
    "io.StringIO().writelines(e())",
    "io.BytesIO().seek(10 ** 15)",
    "x = io.BytesIO(); x.seek(10 ** 15); x.write(b'a')",
    "x = io.BytesIO(); x.truncate(10 ** 15)",
    "memoryview(bytes(10 ** 6)).tolist()",
    "memoryview(bytes(10 ** 6)).hex(' ')",
    "bytes.fromhex('00 ' * 10 ** 6)",
    "iter(int, 1).__reduce__",
    "list(iter(int, 1))",
    "sum(iter(int, 1))",
    "max(iter(int, 1))",
    "type('C', (), {'__len__': lambda s: 1 << 62})() * 3",
    "list(type('C', (), {'__iter__': lambda s: s, '__next__': lambda s: 1})())",
    "''.join(iter(str, 1))",
    "complex(2, 3) ** 10 ** 9",
    "2.5 ** 10 ** 9",
    "slice(0, 10 ** 30, 1).indices(10 ** 20)",
    "[][10 ** 30:]",
    "exec('1\\n' * 10 ** 5)",
    "eval('+'.join(['1'] * 900))",
    "compile('x = [' + '1, ' * 10 ** 5 + ']', 'a', 'exec')",
    "time.sleep(1e300)",
];

const MODULES: &[&str] = &[
    "bisect",
    "collections",
    "contextlib",
    "copy",
    "dataclasses",
    "datetime",
    "enum",
    "functools",
    "heapq",
    "io",
    "itertools",
    "json",
    "math",
    "operator",
    "queue",
    "random",
    "re",
    "statistics",
    "string",
    "struct",
    "time",
    "typing",
];

const BEGIN: &str = "
def forever():
    while True: yield 0
class Items:
    def __getitem__(self, at): return 0
def no(*a): return False
def pair(*a, **k): return a
def asked(r):
    if hasattr(r, '__next__'):
        next(r)
        next(r)
";

/// The modules that a text names, and what all acts use. To import what is not used takes longer than most acts.
fn begin(text: &str) -> String {
    let named = |module: &&&str| text.contains(&format!("{module}."));
    let lines = MODULES.iter().filter(named);
    let lines: String = lines.map(|module| format!("import {module}\n")).collect();
    format!("{lines}{BEGIN}")
}

/// Acts of the functions and methods that take all that such an iterator has, found by giving them one with an end.
fn acts_with(endless: &str) -> Vec<String> {
    let names: Vec<&str> = elite_syntax::python_names::builtin_names()
        .filter(|name| name.starts_with(char::is_lowercase))
        .collect();
    let forms = FORMS.join(", lambda f, e: ");
    let modules = MODULES.join(", ");
    let text = format!(
        "
import {modules}
{BEGIN}
modules = [{modules}]
class Counted:
    def __init__(self, values): self.values = values
    def __iter__(self): return self
    def __next__(self):
        global taken
        taken += 1
        if taken > 50: raise StopIteration
        return next(self.values)
class CountedItems:
    def __getitem__(self, at):
        global taken
        taken += 1
        if at > 50: raise IndexError
        return 0
def ended(): return CountedItems() if {endless:?} == 'Items()' else Counted(iter({endless}))
forms = [lambda f, e: {forms}]
skipped = ('exit', 'quit', 'input', 'open', 'breakpoint', 'sleep', '__class__', '__del__')
functions = {names:?}
for module in modules:
    functions += [module.__name__ + '.' + name for name in dir(module) if name[0] != '_']
for receiver in {RECEIVERS:?}:
    functions += [f'({{receiver}}).{{name}}' for name in dir(eval(receiver))]
print('=', len(functions))
for function in functions:
    if function.split('.')[-1] in skipped: continue
    for number, form in enumerate(forms):
        taken = 0
        try: form(eval(function), ended)
        except Exception: pass
        if taken > 50: print('=', number, function)
"
    );
    let output = Task::new().run(&text);
    let mut lines = output.lines().filter_map(|line| line.strip_prefix("= "));
    let all: usize = lines.next().expect(&output).parse().expect("a number");
    assert!(all > 800, "{all} functions");
    let act = |line: &str| {
        let (number, function) = line.split_once(' ').expect("a number and a function");
        let form = FORMS[number.parse::<usize>().expect("a number")];
        let form = form.replace("e()", endless);
        form.replacen("f(", &format!("{function}("), 1)
    };
    lines.map(act).collect()
}

/// Runs each act; what keeps the program from being stopped.
fn trouble(acts: Vec<String>) -> Vec<String> {
    let (say, heard) = mpsc::channel();
    let worker = std::thread::spawn(move || {
        let limits = Limits {
            memory_bytes: 64 << 20,
            ..Limits::default()
        };
        let task = Task::with(Vec::new(), limits);
        let mut trouble = Vec::new();
        for act in acts {
            let _ = say.send(act.clone());
            let text = format!(
                "{}print('go')\nfor _ in range(2): pass\ntry:\n    {act}\nexcept Exception: pass\n",
                begin(&act)
            );
            let tries = (0..TRIES).map(|_| longest(&task, &text, 3));
            let mut too_long = tries.take_while(|stretch| *stretch > STRETCH_MAX);
            if let Some(last) = too_long.nth(TRIES - 1) {
                trouble.push(format!("{act}: {last:?}"));
            }
        }
        trouble
    });
    let mut act = String::new();
    loop {
        match heard.recv_timeout(SILENCE_MAX) {
            Ok(next) => act = next,
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("no safepoint: {act}"),
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
        }
    }
    match worker.join() {
        Ok(trouble) => trouble,
        Err(_) => vec![format!("a panic: {act}")],
    }
}

macro_rules! kinds {
    ($($name:ident $kind:literal;)*) => {
        $(#[test] fn $name() {
            let acts = acts_with(ENDLESS[$kind]);
            assert!(acts.len() > 100, "{} acts", acts.len());
            let trouble = trouble(acts);
            assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
        })*
        const _: () = assert!([$($kind,)*].len() == ENDLESS.len());
    };
}

kinds! {
    a_stop_reaches_natives_with_texts_of_nothing 0;
    a_stop_reaches_natives_with_pairs 1;
    a_stop_reaches_natives_with_numbers 2;
    a_stop_reaches_natives_with_a_generator 3;
    a_stop_reaches_natives_with_items 4;
    a_stop_reaches_natives_with_zeros 5;
    a_stop_reaches_natives_with_bytes_of_nothing 6;
    a_stop_reaches_natives_with_lists 7;
}

#[test]
fn a_stop_reaches_work_without_an_end() {
    let acts: Vec<String> = ACTS
        .iter()
        .flat_map(|act| {
            let endless = match act.contains("e()") {
                true => ENDLESS,
                false => &ENDLESS[..1],
            };
            endless.iter().map(|endless| act.replace("e()", endless))
        })
        .collect();
    let trouble = trouble(acts);
    assert!(trouble.is_empty(), "\n{}", trouble.join("\n"));
}
