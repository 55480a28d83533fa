"""Character sets, templates and formatters."""
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
        mapping = dict(args[0]) if args else {}
        mapping.update(kws)
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
            elif value in mapping:
                out.append(str(mapping[value]))
            elif safe:
                out.append(source)
            else:
                raise KeyError(value)
        return "".join(out)

    def substitute(self, /, *args, **kws):
        return self._fill(args, kws, False)

    def safe_substitute(self, /, *args, **kws):
        return self._fill(args, kws, True)


class Formatter:
    def format(self, format_string, /, *args, **kwargs):
        return format_string.format(*args, **kwargs)

    def vformat(self, format_string, args, kwargs):
        return format_string.format(*args, **kwargs)
