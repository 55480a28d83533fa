"""Character sets, templates and formatters."""
from _string import formatter_field_name_split as _formatter_field_name_split, formatter_parser as _formatter_parser
whitespace = " \t\n\r\v\f"
ascii_lowercase = "abcdefghijklmnopqrstuvwxyz"
ascii_uppercase = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
ascii_letters = ascii_lowercase + ascii_uppercase
digits = "0123456789"
hexdigits = digits + "abcdef" + "ABCDEF"
octdigits = "01234567"
punctuation = r"""!"#$%&'()*+,-./:;<=>?@[\]^_`{|}~"""
printable = digits + ascii_letters + punctuation + whitespace


def capwords(s, sep=None):
    return (sep or " ").join(word.capitalize() for word in s.split(sep))


class Template:
    """Text with `$name` and `${name}` to fill in."""

    delimiter = "$"

    def __init__(self, template):
        self.template = template

    def _parts(self):
        import re as _re
        text, at = self.template, 0
        if not isinstance(text, str):
            _re.match("", text)  # raises, in the words of patterns
        while True:
            found = text.find(self.delimiter, at)
            if found < 0:
                yield "text", text[at:], text[at:], at
                return
            yield "text", text[at:found], "", at
            rest = text[found + len(self.delimiter):]
            if rest.startswith(self.delimiter):
                yield "text", self.delimiter, "", found
                at = found + 2 * len(self.delimiter)
                continue
            match = _re.match(r"\{([_a-zA-Z][_a-zA-Z0-9]*)\}|([_a-zA-Z][_a-zA-Z0-9]*)", rest)
            if match is None:
                yield "invalid", self.delimiter, "", found
                at = found + len(self.delimiter)
                continue
            at = found + len(self.delimiter) + match.end()
            yield "name", match.group(1) or match.group(2), text[found:at], found

    def _fill(self, args, kws, safe):
        mapping = args[0] if args else kws
        out = []
        for kind, value, source, at in self._parts():
            if kind == "text":
                out.append(value)
            elif kind == "invalid":
                if not safe:
                    lines = self.template[:at].splitlines(keepends=True)
                    line, column = (1, 1) if not lines else (len(lines), at - len("".join(lines[:-1])) + 1)
                    raise ValueError(f"Invalid placeholder in string: line {line}, col {column}")
                out.append(value)
            else:
                try:
                    out.append(str(kws[value] if value in kws else mapping[value]))
                except KeyError:
                    if not safe:
                        raise
                    out.append(source)
        return "".join(out)

    def substitute(self, /, *args, **kws):
        return self._fill(args, kws, False)

    def safe_substitute(self, /, *args, **kws):
        return self._fill(args, kws, True)


class Formatter:
    """Formats like `str.format`; each step is a method for classes derived from it."""

    def format(self, format_string, /, *args, **kwargs):
        return self.vformat(format_string, args, kwargs)

    def vformat(self, format_string, args, kwargs):
        used = set()
        text = self._filled(format_string, args, kwargs, used, _Numbering(), 2)
        self.check_unused_args(used, args, kwargs)
        return text

    def _filled(self, format_string, args, kwargs, used, numbering, depth):
        if depth < 0:
            raise ValueError("Max string recursion exceeded")
        out = []
        for literal, name, spec, conversion in self.parse(format_string):
            if literal:
                out.append(literal)
            if name is not None:
                value, key = self.get_field(numbering.counted(name), args, kwargs)
                used.add(key)
                value = self.convert_field(value, conversion)
                spec = self._filled(spec, args, kwargs, used, numbering, depth - 1)
                out.append(self.format_field(value, spec))
        return "".join(out)

    def parse(self, format_string):
        return iter(_formatter_parser(format_string))

    def get_field(self, field_name, args, kwargs):
        first, steps = _formatter_field_name_split(field_name)
        value = self.get_value(first, args, kwargs)
        for is_attribute, key in steps:
            value = getattr(value, key) if is_attribute else value[key]
        return value, first

    def get_value(self, key, args, kwargs):
        return (args if isinstance(key, int) else kwargs)[key]

    def check_unused_args(self, used_args, args, kwargs):
        pass

    def convert_field(self, value, conversion):
        if conversion is None:
            return value
        functions = {"s": str, "r": repr, "a": ascii}
        if conversion not in functions:
            raise ValueError(f"Unknown conversion specifier {conversion!s}")
        return functions[conversion](value)

    def format_field(self, value, format_spec):
        return format(value, format_spec)


class _Numbering:
    """The numbers of the fields without one: the next, or None where the fields have their own."""

    def __init__(self):
        self.next = 0

    def counted(self, name):
        is_number = name.isdigit()
        if name and not is_number:
            return name
        if is_number and self.next or not is_number and self.next is None:
            raise ValueError("cannot switch from manual field specification to automatic field numbering")
        if is_number:
            self.next = None
            return name
        self.next += 1
        return str(self.next - 1)
