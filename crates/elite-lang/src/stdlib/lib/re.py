"""Regular expressions. Searches that would step back for ever raise RuntimeError."""
from _re import _compile, Pattern, Match


class RegexFlag(int):
    """Options of a pattern, combined with `|`."""
    __module__ = "re"

    def __or__(self, other):
        return RegexFlag(int(self) | int(other))

    def __and__(self, other):
        return RegexFlag(int(self) & int(other))

    def __xor__(self, other):
        return RegexFlag(int(self) ^ int(other))

    def __invert__(self):
        return RegexFlag(~int(self) & 511)

    __ror__, __rand__, __rxor__ = __or__, __and__, __xor__

    def __repr__(self):
        names = ((256, "ASCII"), (2, "IGNORECASE"), (4, "LOCALE"), (32, "UNICODE"), (8, "MULTILINE"), (16, "DOTALL"),
                 (64, "VERBOSE"))
        return "|".join(f"re.{name}" for bit, name in names if int(self) & bit) or "re.NOFLAG"

    __str__ = __repr__
    value = property(int)


A = ASCII = RegexFlag(256)
I = IGNORECASE = RegexFlag(2)
L = LOCALE = RegexFlag(4)
M = MULTILINE = RegexFlag(8)
S = DOTALL = RegexFlag(16)
U = UNICODE = RegexFlag(32)
X = VERBOSE = RegexFlag(64)
NOFLAG = RegexFlag(0)


class error(Exception):
    def __init__(self, msg, pattern=None, pos=None):
        self.msg = msg
        self.pattern = pattern
        self.pos = pos
        if pattern is not None and pos is not None:
            newline = "\n" if isinstance(pattern, str) else b"\n"
            self.lineno = pattern.count(newline, 0, pos) + 1
            self.colno = pos - pattern.rfind(newline, 0, pos)
            msg = f"{msg} at position {pos}"
            if newline in pattern:
                msg = f"{msg} (line {self.lineno}, column {self.colno})"
        else:
            self.lineno = self.colno = None
        super().__init__(msg)


_cache = {}


def compile(pattern, flags=0):
    if isinstance(pattern, Pattern):
        if flags:
            raise ValueError("cannot process flags argument with a compiled pattern")
        return pattern
    flags = int(flags)
    key = type(pattern), pattern, flags
    try:
        return _cache[key]
    except KeyError:
        pass
    made = _compile(pattern, flags, error)
    if len(_cache) >= 512:
        del _cache[next(iter(_cache))]
    _cache[key] = made
    return made


def search(pattern, string, flags=0):
    return compile(pattern, flags).search(string)


def match(pattern, string, flags=0):
    return compile(pattern, flags).match(string)


def fullmatch(pattern, string, flags=0):
    return compile(pattern, flags).fullmatch(string)


def findall(pattern, string, flags=0):
    return compile(pattern, flags).findall(string)


def finditer(pattern, string, flags=0):
    return compile(pattern, flags).finditer(string)


def split(pattern, string, maxsplit=0, flags=0):
    return compile(pattern, flags).split(string, maxsplit)


def sub(pattern, repl, string, count=0, flags=0):
    return _subn(compile(pattern, flags), repl, string, count)[0]


def subn(pattern, repl, string, count=0, flags=0):
    return _subn(compile(pattern, flags), repl, string, count)


def purge():
    _cache.clear()


_special = {c: "\\" + c for c in "()[]{}?*+-|^$\\.&~# \t\n\r\v\f"}


def escape(pattern):
    if isinstance(pattern, bytes):
        return "".join(_special.get(c, c) for c in pattern.decode("latin-1")).encode("latin-1")
    return "".join(_special.get(c, c) for c in pattern)


def _subn(self, repl, string, count=0):
    if not callable(repl):
        if not _is_literal(repl):
            hash(repl)  # CPython keeps templates in a dictionary
        repl = _template(self, repl)
    return self._subn(repl, string, count)


_escapes = {"a": "\a", "b": "\b", "f": "\f", "n": "\n", "r": "\r", "t": "\t", "v": "\v", "\\": "\\"}


def _is_literal(template):
    """Whether a replacement is a text in which nothing has to be put in place."""
    for kind in (str, bytes, bytearray):
        if isinstance(template, kind):
            return kind.find(template, "\\" if kind is str else b"\\") < 0
    return False


def _template(pattern, source):
    """The texts and group numbers that a replacement is made of."""
    is_bytes = isinstance(source, (bytes, bytearray))
    if _is_literal(source):
        return [source]
    text = bytes(source).decode("latin-1") if is_bytes else source
    if not isinstance(text, str):
        str(source, "latin1")  # raises, in its own words
    parts, plain, at = [], "", 0

    def group(index, position):
        nonlocal plain
        if index > pattern.groups:
            raise error(f"invalid group reference {index}", source, position)
        parts.append(plain)
        parts.append(index)
        plain = ""

    while at < len(text):
        c = text[at]
        if c != "\\":
            plain += c
            at += 1
            continue
        start = at
        at += 2
        c = text[start + 1:at]
        if not c:
            raise error("bad escape (end of pattern)", source, start)
        if c == "g":
            if text[at:at + 1] != "<":
                raise error("missing <", source, at)
            end = text.find(">", at)
            name = text[at + 1:end] if end >= 0 else text[at + 1:]
            if not name:
                raise error("missing group name", source, at + 1)
            if end < 0:
                raise error("missing >, unterminated name", source, at + 1)
            if name.isdigit():
                index = int(name)
            elif not name.isidentifier():
                raise error(f"bad character in group name {name!r}", source, at + 1)
            elif name in pattern.groupindex:
                index = pattern.groupindex[name]
            else:
                raise IndexError(f"unknown group name {name!r}")
            group(index, at + 1)
            at = end + 1
        elif c == "0":
            digits = ""
            while len(digits) < 2 and text[at:at + 1] in ("0", "1", "2", "3", "4", "5", "6", "7"):
                digits += text[at]
                at += 1
            plain += chr(int("0" + digits, 8))
        elif c.isdigit():
            digits = c
            if text[at:at + 1].isdigit():
                digits += text[at]
                at += 1
                third = text[at:at + 1]
                if third and third in "01234567" and all(d in "01234567" for d in digits):
                    code = int(digits + third, 8)
                    if code > 0o377:
                        raise error(f"octal escape value \\{digits + third} outside of range 0-0o377", source, start)
                    plain += chr(code)
                    at += 1
                    continue
            group(int(digits), start + 1)
        elif c in _escapes:
            plain += _escapes[c]
        elif c.isascii() and c.isalpha():
            raise error(f"bad escape \\{c}", source, start)
        else:
            plain += "\\" + c
    parts.append(plain)
    if is_bytes:
        return [part.encode("latin-1") if isinstance(part, str) else part for part in parts]
    return parts


def _expand(match, template):
    """`Match.expand`: a template with the groups of a match in place."""
    empty = match.string[:0]
    texts = [part if not isinstance(part, int) else match.group(part) for part in _template(match.re, template)]
    return empty.join([empty if text is None else text for text in texts])
