"""Encodings by name, as functions and as classes that take a text or bytes piece by piece.

The encodings themselves are native, those of str.encode and bytes.decode; from bytes to bytes there are hex and base64,
from text to text rot13.
"""

import _codecs

BOM_UTF8 = b"\xef\xbb\xbf"
BOM_LE = BOM_UTF16_LE = BOM_UTF16 = BOM = BOM32_LE = b"\xff\xfe"
BOM_BE = BOM_UTF16_BE = BOM32_BE = b"\xfe\xff"
BOM_UTF32_LE = BOM_UTF32 = BOM64_LE = b"\xff\xfe\x00\x00"
BOM_UTF32_BE = BOM64_BE = b"\x00\x00\xfe\xff"


class CodecInfo(tuple):
    """The functions and classes of an encoding; the first four are items, too."""

    def __new__(cls, encode, decode, streamreader=None, streamwriter=None, incrementalencoder=None,
                incrementaldecoder=None, name=None):
        self = super().__new__(cls, (encode, decode, streamreader, streamwriter))
        self.name, self.encode, self.decode = name, encode, decode
        self.streamreader, self.streamwriter = streamreader, streamwriter
        self.incrementalencoder, self.incrementaldecoder = incrementalencoder, incrementaldecoder
        return self

    def __repr__(self):
        return f"<codecs.CodecInfo object for encoding {self.name} at {id(self):#x}>"


class IncrementalEncoder:
    """Takes a text in pieces; of a mark at the beginning it makes one."""

    encoding = None

    def __init__(self, errors="strict"):
        self.errors = errors
        self.reset()

    def encode(self, input, final=False):
        data = input.encode(self._goes_on, self.errors)
        if self._goes_on == self.encoding and self.encoding in _WITH_MARK:
            # The mark has been written: what follows is in the order of bytes it stands for.
            self._goes_on = _WITH_MARK[self.encoding]
        return data

    def reset(self):
        self._goes_on = self.encoding

    def getstate(self):
        return int(self._goes_on != self.encoding)

    def setstate(self, state):
        self._goes_on = _WITH_MARK.get(self.encoding, self.encoding) if state else self.encoding


class IncrementalDecoder:
    """Takes bytes in pieces; what is cut at the end of one waits for the next."""

    encoding = None

    def __init__(self, errors="strict"):
        self.errors = errors
        self.reset()

    def decode(self, input, final=False):
        data = self._kept + bytes(input)
        if self._encoding in _MARKS:
            marks, plain = _MARKS[self._encoding]
            found = [(mark, encoding) for mark, encoding in marks if data.startswith(mark)]
            if not found and not final and any(mark.startswith(data) for mark, _ in marks):
                self._kept = data
                return ""
            # Without a mark the order of bytes is that of the machine.
            mark, self._encoding = found[0] if found else (b"", plain)
            data = data[len(mark):]
        text, length = _codecs.decode(data, self._encoding, self.errors, final)
        self._kept = data[length:]
        return text

    def reset(self):
        self._kept, self._encoding = b"", self.encoding

    def getstate(self):
        return self._kept, 0

    def setstate(self, state):
        self.reset()
        self._kept = state[0]


_WITH_MARK = {"utf-16": "utf-16-le", "utf-32": "utf-32-le", "utf-8-sig": "utf-8"}
_MARKS = {
    "utf-16": (((BOM_UTF16_LE, "utf-16-le"), (BOM_UTF16_BE, "utf-16-be")), "utf-16-le"),
    "utf-32": (((BOM_UTF32_LE, "utf-32-le"), (BOM_UTF32_BE, "utf-32-be")), "utf-32-le"),
    "utf-8-sig": (((BOM_UTF8, "utf-8"),), "utf-8"),
}


def _rotated(text):
    low, high = "abcdefghijklmnopqrstuvwxyz", "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    turned = (half[13:] + half[:13] for half in (low, high))
    return text.translate(str.maketrans(low + high, "".join(turned)))


_DIGITS64 = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"


def _to_base64(data):
    """Lines of 76 characters, each with its end."""
    lines = []
    for start in range(0, len(data), 57):
        line = bytearray()
        for at in range(start, min(start + 57, len(data)), 3):
            three = data[at:at + 3]
            bits = int.from_bytes(three.ljust(3, b"\0"), "big")
            line += bytes(_DIGITS64[bits >> shift & 63] for shift in (18, 12, 6, 0)[:len(three) + 1]).ljust(4, b"=")
        lines.append(bytes(line) + b"\n")
    return b"".join(lines)


def _from_base64(data):
    """Characters that are none of base64 are left out."""
    out, bits, count = bytearray(), 0, 0
    for byte in bytes(data):
        place = _DIGITS64.find(byte)
        if place < 0:
            continue
        bits, count = (bits << 6 | place) & 0xffffff, count + 1
        if count % 4:
            out.append(bits >> (6, 4, 2)[count % 4 - 1] & 255) if count % 4 > 1 else None
        else:
            out.append(bits & 255)
    if count % 4 == 1:
        raise ValueError("Invalid base64-encoded string: number of data characters cannot be 1 more than a multiple "
                         "of 4")
    return bytes(out)


_OTHERS = {
    "hex": (lambda data: data.hex().encode(), lambda data: bytes.fromhex(bytes(data).decode("ascii"))),
    "base64": (_to_base64, _from_base64),
    "rot13": (_rotated, _rotated),
}
_OTHERS |= {"hex_codec": _OTHERS["hex"], "base64_codec": _OTHERS["base64"], "rot_13": _OTHERS["rot13"]}


def _other(encoding):
    return _OTHERS.get(encoding.lower().replace("-", "_")) if isinstance(encoding, str) else None


def encode(obj, encoding="utf-8", errors="strict"):
    other = _other(encoding)
    return other[0](obj) if other else lookup(encoding).encode(obj, errors)[0]


def decode(obj, encoding="utf-8", errors="strict"):
    other = _other(encoding)
    return other[1](obj) if other else lookup(encoding).decode(obj, errors)[0]


def lookup(encoding, /):
    other = _other(encoding)
    if other:
        return CodecInfo(lambda data, errors="strict": (other[0](data), len(data)),
                         lambda data, errors="strict": (other[1](data), len(data)), name=encoding)
    name = _codecs.name(encoding)

    def encoded(text, errors="strict"):
        if not isinstance(text, str):
            raise TypeError(f"{name.replace('-', '_')}_encode() argument 1 must be str, not {type(text).__name__}")
        return text.encode(name, errors), len(text)

    def decoded(data, errors="strict"):
        return bytes(data).decode(name, errors), len(data)

    encoder = type("IncrementalEncoder", (IncrementalEncoder,), {"encoding": name})
    decoder = type("IncrementalDecoder", (IncrementalDecoder,), {"encoding": name})
    return CodecInfo(encoded, decoded, None, None, encoder, decoder, name)


def getencoder(encoding):
    return lookup(encoding).encode


def getdecoder(encoding):
    return lookup(encoding).decode


def getincrementalencoder(encoding):
    return lookup(encoding).incrementalencoder


def getincrementaldecoder(encoding):
    return lookup(encoding).incrementaldecoder


def iterencode(iterator, encoding, errors="strict", **kwargs):
    encoder = getincrementalencoder(encoding)(errors, **kwargs)
    for text in iterator:
        data = encoder.encode(text)
        if data:
            yield data
    data = encoder.encode("", True)
    if data:
        yield data


def iterdecode(iterator, encoding, errors="strict", **kwargs):
    decoder = getincrementaldecoder(encoding)(errors, **kwargs)
    for data in iterator:
        text = decoder.decode(data)
        if text:
            yield text
    text = decoder.decode(b"", True)
    if text:
        yield text


def register_error(errors, handler, /):
    """From now on the handler is asked about what does not fit, under this name."""
    if not isinstance(errors, str):
        raise TypeError(f"register_error() argument 1 must be str, not {type(errors).__name__}")
    if not callable(handler):
        raise TypeError("handler must be callable")
    _codecs.handlers[errors] = handler


def strict_errors(exception, /):
    raise exception


def ignore_errors(exception, /):
    return "", exception.end


def replace_errors(exception, /):
    if isinstance(exception, UnicodeEncodeError):
        return "?" * (exception.end - exception.start), exception.end
    return "\ufffd", exception.end


def _by_native(errors):
    def handle(exception, /):
        part = exception.object[exception.start:exception.end]
        if isinstance(exception, UnicodeEncodeError):
            return part.encode("ascii", errors).decode("ascii"), exception.end
        return part.decode("ascii", errors), exception.end

    handle.__name__ = errors + "_errors"
    return handle


xmlcharrefreplace_errors = _by_native("xmlcharrefreplace")
backslashreplace_errors = _by_native("backslashreplace")
namereplace_errors = _by_native("namereplace")
_OWN_HANDLERS = {
    "strict": strict_errors, "ignore": ignore_errors, "replace": replace_errors,
    "xmlcharrefreplace": xmlcharrefreplace_errors, "backslashreplace": backslashreplace_errors,
    "namereplace": namereplace_errors,
}


def lookup_error(errors, /):
    found = _codecs.handlers.get(errors) or _OWN_HANDLERS.get(errors)
    if found is None:
        raise LookupError(f"unknown error handler name {errors!r}")
    return found


def open(filename, mode="r", encoding=None, errors="strict", buffering=-1):
    """A file of text; without an encoding one of bytes."""
    from io import open as plain
    if encoding is None:
        return plain(filename, mode, buffering)
    return plain(filename, mode.replace("b", ""), buffering, encoding, errors, newline="")


def _pair(encoding):
    return getencoder(encoding), getdecoder(encoding)


ascii_encode, ascii_decode = _pair("ascii")
latin_1_encode, latin_1_decode = _pair("latin-1")
utf_8_encode, utf_8_decode = _pair("utf-8")
