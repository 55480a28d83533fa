//! Where CPython is not asked, and where it may differ.

use super::kinds::ContainerKind;

/// Trials that end CPython 3.11.7 itself, or have it write to memory that is no longer its own.
pub const NOT_FOR_CPYTHON: &[(&str, &str)] = &[
    ("list", "put(c, slice(0, 6, 2), stepping([5, 6, 7]))"),
    (
        "subclass of list",
        "put(c, slice(0, 6, 2), stepping([5, 6, 7]))",
    ),
    ("bytearray", "put(c, H(1), H(5))"),
    ("bytearray", "put(c, 1, H(5))"),
    ("bytearray", "put(c, -1, H(5))"),
    ("bytearray", "put(c, H(-1), 5)"),
    ("bytearray", "put(c, H(1), 5)"),
    ("bytearray", "put(c, H(9), 5)"),
    ("bytearray", "put(c, slice(None, None, H(2)), [5, 6, 7])"),
    (
        "bytearray",
        "put(c, slice(None, None, H(-1)), [5, 6, 7, 8, 9, 4])",
    ),
    ("bytearray", "c.__setitem__(H(1), H(2))"),
    ("bytearray", "c.__setitem__(H(1), 5)"),
    ("bytearray", "c.__setitem__(H(4), 7)"),
    ("bytearray", "c.__setitem__(0, H(5))"),
];

/// Kinds that are only to be survived, whatever comes out, and why.
pub const ONLY_HERE: &[(&str, &str)] = &[
    (
        "ordered dict",
        "CPython's ends the process when it changes while it is walked through",
    ),
    (
        "counter",
        "CPython's is script code, which looks each key up more than once",
    ),
];

/// Differences from CPython that are meant or of no account: the kind, a part of the line, the reason.
pub const DIFFERENCES: &[(&str, &str, &str)] = &[
    (
        "",
        "c.__format__(",
        "the specification is read as text before it is refused",
    ),
    (
        "",
        "c.__iadd__(H",
        "NotImplemented, so that the other operand has its turn",
    ),
    ("", "c.__radd__(", "CPython's sequences have none"),
    (
        "",
        "c.__bool__(",
        "CPython's containers have `__len__` only",
    ),
    ("list", "c.sort(H.", "the manual has sort(function)"),
    ("list", "c.sort({", "the manual has sort(function)"),
    ("deque", "c.index(", "where the change is noticed"),
    (
        "",
        "collections.OrderedDict(c)",
        "CPython's looks whether the other one changes after each key",
    ),
    (
        "",
        "c.__ror__(",
        "CPython notices that the other one changes",
    ),
    (
        "dict",
        "{H(1): H(2)} | c",
        "CPython notices that the other one changes",
    ),
    ("dict", "c.keys() & ", "the smaller one is walked through"),
    (
        "dict",
        "c.keys() | ",
        "the keys are copied with their hashes",
    ),
    (
        "dict",
        "c.keys() - ",
        "the keys are copied with their hashes",
    ),
    (
        "dict",
        "c.keys() ^ ",
        "the keys are copied with their hashes",
    ),
    ("dict", "c.items() & ", "the smaller one is walked through"),
    (
        "set",
        "| 2 ",
        "objects that hash by their addresses have no order",
    ),
    (
        "set",
        "c.isdisjoint(c)",
        "CPython asks nothing of a set and itself",
    ),
    ("set", "c.issuperset(H", "it is made a set first"),
    // CPython refuses to change a bytearray while it is in use, or goes on with memory that is no longer its own.
    ("bytearray", "c.join(", "BufferError"),
    ("bytearray", "c.find(", "other memory"),
    ("bytearray", "c.rfind(", "other memory"),
    ("bytearray", "c.index(", "other memory"),
    ("bytearray", "c.rindex(", "other memory"),
    ("bytearray", "c.count(", "other memory"),
    ("bytearray", "c.rsplit(maxsplit", "other memory"),
    ("bytearray", "c.startswith(b'ab', H", "other memory"),
    ("bytearray", "c.endswith(b'ab', H", "other memory"),
    ("bytearray", "H(2) in c", "other memory"),
    ("bytearray", "H(9) in c", "other memory"),
    ("bytearray", "c.__contains__(H", "other memory"),
    (
        "bytearray",
        "c.replace(",
        "the count is read before the texts are refused",
    ),
    (
        "bytearray",
        "c.hex(",
        "the bytes are read before the arguments",
    ),
    (
        "bytearray",
        "c.__init__(",
        "changes when the new bytes are there",
    ),
    (
        "class",
        "vars(c).items()",
        "the attributes of a class are shown as a copy",
    ),
    (
        "class",
        "type('Y', (c,), {'a0'",
        "a class that is dropped is gone at once",
    ),
    (
        "function",
        "vars(c)",
        "the attributes of a function are shown as a copy",
    ),
    ("exception", "c.__reduce__(", "there is no pickle"),
    ("exception", "raising", "tracebacks keep no variables alive"),
    ("exception", "c.__setstate__(", "there is no pickle"),
    (
        "exception",
        "c.args ==",
        "tuples of other lengths are unequal without asking",
    ),
    (
        "file",
        "c.",
        "files are classes of the library in script code",
    ),
    (
        "file of bytes",
        "c.",
        "files are classes of the library in script code",
    ),
    (
        "file",
        "(c)",
        "files are classes of the library in script code",
    ),
    (
        "file of bytes",
        "(c)",
        "files are classes of the library in script code",
    ),
];

/// Whether a difference is one of those. A method of an operator that does not know the other operand says
/// `NotImplemented` here, where some of CPython's raise at once.
pub fn is_meant(kind: &ContainerKind, ours: &str, theirs: &str) -> bool {
    let listed =
        |(of, part, _): &(&str, &str, &str)| kind.name.ends_with(of) && ours.contains(part);
    DIFFERENCES.iter().any(listed)
        || ours.contains(".__")
            && ours.contains("-> NotImplementedType")
            && theirs.contains("-> 'TypeError'")
}
