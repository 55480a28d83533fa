//! Data for the library's own parsers: mutation alone would take long to write such calls.

/// What uses the data: `A` and `B` are its halves, `D` all of it as bytes.
const HARNESSES: [&str; 12] = [
    "import re\np = re.compile(A)\nfor m in p.finditer(B): m.groups(), m.groupdict(), m.span()\np.sub(B, B)\n\
     p.split(B)\np.fullmatch(B)\nre.escape(A)",
    "import json\nv = json.loads(A)\nassert json.loads(json.dumps(v)) == v, 'BROKEN'\n\
     json.dumps(v, indent=B, sort_keys=True)",
    "import struct\nstruct.calcsize(A)\nstruct.unpack(A, D[:struct.calcsize(A)])\nlist(struct.iter_unpack(A, D))\n\
     struct.pack(A, *range(9))",
    "import datetime as d\nd.datetime.strptime(A, B)\nd.datetime(2024, 2, 29).strftime(A)\n\
     d.datetime.fromisoformat(A)\nd.date.fromisoformat(B)",
    "format(3.75, A)\nformat(-12345, A)\nformat(B, A)\nformat(2j, A)\nA % (1, B, 2.5)\nA % {'a': 1}\n\
     A.format(1, B, a=[2])",
    "int(A)\nint(A, 0)\nfloat(A)\ncomplex(A)\nbytes.fromhex(A)\nint(B, 36)\neval(A)\nD.decode(B)\n\
     A.encode(B, 'replace')",
    "exec(A, {})\ncompile(B, '', 'exec')",
    "import os, subprocess, socket, io\n\
     for f in (lambda: open(A), lambda: os.listdir(A), lambda: subprocess.run([A]), lambda: os.system(B), lambda: \
     os.remove(A), lambda: os.kill(1, 9), lambda: os.environ[A]):\n    try: f()\n    except PermissionError: pass\
     \n    else: raise AssertionError('BROKEN')\nio.StringIO(A).readlines()\nio.BytesIO(D).read(3)\n\
     os.path.normpath(A)\nos.path.join(A, B)",
    "import string, itertools, collections, statistics, copy\nstring.Template(A).safe_substitute(a=B)\n\
     string.capwords(A)\nlist(itertools.islice(itertools.permutations(A, 2), 9))\n\
     collections.Counter(A).most_common()\ncopy.deepcopy([A, D])\ncollections.namedtuple(A, B)",
    "class N: pass\nnodes = [N(), [], {}, lambda: nodes, set()] + [N() for _ in range(5)]\nimport collections\n\
     nodes.append(collections.deque())\nfor a, b in zip(D, D[1:]):\
     \n    x, y = nodes[a % len(nodes)], nodes[b % len(nodes)]\n    if isinstance(x, list): x.append(y)\
     \n    elif isinstance(x, dict): x[b] = y\n    elif isinstance(x, collections.deque): x.append(y)\
     \n    elif isinstance(x, set): x.add(id(y))\n    else: setattr(x, 'a' + str(b % 4), y)\
     \n    if a > 240: del nodes[0]; nodes.append(N())\n    if b > 250: keep = bytes(4_000_000)\n\
     repr(nodes), nodes == nodes[:]",
    "import enum, dataclasses\nE = enum.Enum('E', A)\nlist(E), E(B)\nF = enum.Flag('F', 'x y z')\n\
     F(len(A)), dataclasses.make_dataclass(A, [B])()",
    "import math, random\nx = int.from_bytes(D[:12], 'little', signed=True)\n\
     math.isqrt(abs(x)), math.gcd(x, 12), x % 7, x ** 3, hex(x), math.factorial(abs(x) % 50), \
     random.Random(A).random(), range(x)[3], len(range(x)), hash(float(x % 10**9) / 7), round(x, -3), pow(x, 5, 97)",
];

/// A program that hands data to a part of the library; the first byte says to which.
pub fn library_program(data: &[u8]) -> String {
    let (first, rest) = data.split_first().unwrap_or((&0, &[]));
    let harness = HARNESSES[usize::from(*first) % HARNESSES.len()];
    let bytes: String = rest.iter().map(|byte| format!("\\x{byte:02x}")).collect();
    let half = rest.len() / 2;
    let text = |part: &[u8]| -> String {
        let characters = String::from_utf8_lossy(part);
        characters
            .chars()
            .map(|c| format!("\\U{:08x}", c as u32))
            .collect()
    };
    let (a, b) = (text(&rest[..half]), text(&rest[half..]));
    // Each line is on its own, so that the first error does not hide the others.
    let mut out = format!("A, B, D = '{a}', '{b}', b'{bytes}'\n");
    for line in harness.split('\n') {
        // A line that belongs to the one before stays with it.
        let belongs = ["assert", "else", "try", "except", "    ", "nodes", "class"];
        let is_open = line.ends_with(':') || belongs.iter().any(|word| line.starts_with(word));
        if is_open {
            out.push_str(&format!("{line}\n"));
        } else {
            out.push_str(&format!("try:\n    {line}\nexcept Exception: pass\n"));
        }
    }
    out
}
