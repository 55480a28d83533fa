//! The kinds of values that can be changed, how each is made and what is done to it meanwhile.

use super::uses::{
    OF_CLASSES, OF_COUNTERS, OF_EXCEPTIONS, OF_FILES, OF_FUNCTIONS, OF_INSTANCES, OF_MAPS,
    OF_SEQUENCES, OF_SETS,
};

/// A kind of container: how it is made of the items `i`, and what is done to it meanwhile.
pub struct ContainerKind {
    pub name: &'static str,
    pub make: &'static str,
    pub effects: &'static [&'static str],
    /// Uses beyond calling its methods, `c` being the container.
    pub uses: &'static [&'static str],
    /// Whether it has items, so that what is done with anything that has is done with it, too.
    pub has_items: bool,
}

pub const KINDS: &[ContainerKind] = &[
    ContainerKind {
        name: "list",
        make: "list(i)",
        effects: &[
            "c.clear()",
            "c.extend([7, 8, 9])",
            "del c[-1:]",
            "c[:] = [4]",
            "c.insert(0, 6)",
            "c.reverse()",
        ],
        uses: OF_SEQUENCES,
        has_items: true,
    },
    ContainerKind {
        name: "deque",
        make: "collections.deque(i)",
        effects: &["c.clear()", "c.extend([7, 8, 9])", "c.pop()", "c.rotate(1)"],
        uses: OF_SEQUENCES,
        has_items: true,
    },
    ContainerKind {
        name: "bytearray",
        make: "bytearray(number(x) for x in i)",
        effects: &[
            "c.clear()",
            "c.extend(b'abcdefgh')",
            "del c[-1:]",
            "c[:] = b'x'",
        ],
        uses: OF_SEQUENCES,
        has_items: true,
    },
    ContainerKind {
        name: "dict",
        make: "{x: x for x in i}",
        effects: &[
            "c.clear()",
            "c.update({7: 1, 8: 2, 9: 3})",
            "c.popitem()",
            "c.update({k: 0 for k in range(5)})",
        ],
        uses: OF_MAPS,
        has_items: true,
    },
    ContainerKind {
        name: "set",
        make: "set(i)",
        effects: &["c.clear()", "c.update([7, 8, 9])", "c.pop()"],
        uses: OF_SETS,
        has_items: true,
    },
    ContainerKind {
        name: "subclass of list",
        make: "L(i)",
        effects: &["c.clear()", "c.extend([7, 8, 9])"],
        uses: OF_SEQUENCES,
        has_items: true,
    },
    ContainerKind {
        name: "subclass of dict",
        make: "D((x, x) for x in i)",
        effects: &["c.clear()", "c.update({7: 1, 8: 2, 9: 3})"],
        uses: OF_MAPS,
        has_items: true,
    },
    ContainerKind {
        name: "ordered dict",
        make: "collections.OrderedDict((x, x) for x in i)",
        effects: &[
            "c.clear()",
            "c.update({7: 1, 8: 2, 9: 3})",
            "c.popitem(last=False)",
            "c.move_to_end(1)",
        ],
        uses: OF_MAPS,
        has_items: true,
    },
    ContainerKind {
        name: "dict with defaults",
        make: "collections.defaultdict(H.none, ((x, x) for x in i))",
        effects: &["c.clear()", "c.update({7: 1, 8: 2, 9: 3})", "c[77]"],
        uses: OF_MAPS,
        has_items: true,
    },
    ContainerKind {
        name: "counter",
        make: "collections.Counter({x: number(x) for x in i})",
        effects: &[
            "c.clear()",
            "c.update({7: 1, 8: 2, 9: 3})",
            "c.subtract([1, 2])",
        ],
        uses: OF_COUNTERS,
        has_items: true,
    },
    ContainerKind {
        name: "instance",
        make: "filled(O(), i)",
        effects: &[
            "c.__dict__.clear()",
            "c.a7 = 1; c.a8 = 2",
            "del c.a1",
            "c.a0 = 5; c.a1 = 6",
        ],
        uses: OF_INSTANCES,
        has_items: false,
    },
    ContainerKind {
        name: "class",
        make: "filled(type('X', (), {}), i)",
        effects: &["c.a7 = 1; c.a8 = 2", "del c.a1", "c.a0 = 5; c.a1 = 6"],
        uses: OF_CLASSES,
        has_items: false,
    },
    ContainerKind {
        name: "function",
        make: "filled(lambda x=1, y=2, *, z=3: act() or [x, y, z], i)",
        effects: &[
            "c.a7 = 1; c.a8 = 2",
            "del c.a1",
            "del c.a0, c.a2",
            "c.__defaults__ = (7, 8)",
        ],
        uses: OF_FUNCTIONS,
        has_items: false,
    },
    ContainerKind {
        name: "exception",
        make: "filled(E(*i), i)",
        effects: &[
            "c.args = ()",
            "c.args = (7, 8, 9)",
            "c.__cause__ = ValueError(1)",
            "del c.a1",
        ],
        uses: OF_EXCEPTIONS,
        has_items: false,
    },
    ContainerKind {
        name: "file",
        make: "io.StringIO('\\n'.join([str(number(x)) for x in i]))",
        effects: &[
            "c.seek(0)",
            "c.truncate(0)",
            "c.write('abc\\ndef')",
            "c.close()",
        ],
        uses: OF_FILES,
        has_items: false,
    },
    ContainerKind {
        name: "file of bytes",
        make: "io.BytesIO(b'\\n'.join([str(number(x)).encode() for x in i]))",
        effects: &[
            "c.seek(0)",
            "c.truncate(0)",
            "c.write(b'abc\\ndef')",
            "c.close()",
        ],
        uses: OF_FILES,
        has_items: false,
    },
];

/// What the containers consist of.
pub const CONTENTS: &[&str] = &[
    "[0, 1, 2, 3, 4, 5]",
    "[H(0), 1, H(2), 3, H(4), H(5)]",
    "[leaving(0), 1, leaving(2), leaving(3)]",
];
