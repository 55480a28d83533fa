"""Files as objects. Those in memory always work, those of the system need the permission of the controller.

Reading and splitting into lines is native (`_files`); this module gives it the faces of Python: text with an encoding
and newlines, bytes, and numbers for `os`."""
import _files

SEEK_SET = 0
SEEK_CUR = 1
SEEK_END = 2
DEFAULT_BUFFER_SIZE = 8192


class UnsupportedOperation(OSError, ValueError):
    __module__ = "io"


def _bytes_of(data):
    """The bytes that something is; what could only be made into bytes is refused."""
    if not isinstance(data, (bytes, bytearray)):
        raise TypeError(f"a bytes-like object is required, not {type(data).__name__!r}")
    return bytes(data)


def _check_room(buffer):
    if not isinstance(buffer, bytearray):
        given = "None" if buffer is None else type(buffer).__name__
        raise TypeError(f"readinto() argument must be read-write bytes-like object, not {given}")


class IOBase:
    """What all files have in common. `closed` is theirs to tell."""

    def __enter__(self):
        self._check()
        return self

    def __exit__(self, *args):
        self.close()

    def __iter__(self):
        self._check()
        return self

    def __next__(self):
        line = self.readline()
        if not line:
            raise StopIteration
        return line

    def _check(self):
        if self.closed:
            raise ValueError("I/O operation on closed file.")

    def readable(self):
        return False

    def writable(self):
        return False

    def seekable(self):
        return False

    def isatty(self):
        self._check()
        return False

    def fileno(self):
        raise UnsupportedOperation("fileno")

    def flush(self):
        self._check()

    def readlines(self, hint=-1, /):
        lines = []
        size = 0
        for line in self:
            lines.append(line)
            size += len(line)
            if hint is not None and 0 < hint <= size:
                break
        return lines

    def writelines(self, lines, /):
        for line in lines:
            self.write(line)


class RawIOBase(IOBase):
    pass


class BufferedIOBase(IOBase):
    pass


class TextIOBase(IOBase):
    pass


class _SystemFile:
    """What text and binary files of the system share."""

    def _open(self, file, name, mode, reads, writes):
        self._file = file
        self._name = name
        self._mode = mode
        self._reads = reads
        self._writes = writes
        self._number = None

    name = property(lambda self: self._name)
    mode = property(lambda self: self._mode)
    closed = property(lambda self: self._file.closed())

    def readable(self):
        self._check()
        return self._reads

    def writable(self):
        self._check()
        return self._writes

    def seekable(self):
        self._check()
        return True

    def fileno(self):
        self._check()
        if self._number is None:
            self._number = _enter(self._file)
        return self._number

    def flush(self):
        self._check()
        self._file.flush()

    def close(self):
        if self._number is not None:
            _descriptors.pop(self._number, None)
            self._number = None
        self._file.close()

    def truncate(self, size=None, /):
        self._check()
        if not self._writes:
            raise UnsupportedOperation("truncate")
        return self._file.truncate(size)

    def tell(self):
        self._check()
        return self._file.tell()


class _BinaryFile(_SystemFile, BufferedIOBase):
    """Bytes of a file of the system."""
    __module__ = "_io"

    def __init__(self, file, name, mode, reads, writes, unbuffered):
        self._open(file, name, mode, reads, writes)
        self._unbuffered = unbuffered

    def __repr__(self):
        return f"<_io.{type(self).__name__} name={self._name!r}>"

    def _may_read(self, what):
        if self.closed:
            raise ValueError(f"{what} of closed file")
        if not self._reads:
            raise UnsupportedOperation(what)

    def read(self, size=-1, /):
        self._may_read("read")
        return self._file.read(size)

    read1 = read

    def peek(self, size=0, /):
        self._may_read("peek")
        data = self._file.read(DEFAULT_BUFFER_SIZE)
        self._file.seek(-len(data), 1)
        return data

    def readline(self, size=-1, /):
        self._may_read("readline")
        return self._file.read_text(size, False, "\n", True, False)

    def readinto(self, buffer, /):
        _check_room(buffer)
        data = self.read(len(buffer))
        buffer[:len(data)] = data
        return len(data)

    def write(self, data, /):
        if not self._writes:
            raise UnsupportedOperation("write")
        if self.closed:
            raise ValueError("write to closed file")
        count = self._file.write(data)
        if self._unbuffered:
            self._file.flush()
        return count

    def seek(self, offset, whence=SEEK_SET, /):
        self._check()
        return self._file.seek(offset, whence)


class BufferedReader(_BinaryFile):
    pass


class BufferedWriter(_BinaryFile):
    pass


class BufferedRandom(_BinaryFile):
    pass


class FileIO(_BinaryFile):
    pass


_UTF8 = ("utf8", "u8")
_BYTES = ("ascii", "usascii", "latin1", "iso88591", "l1", "latin")


def _plain(encoding):
    return encoding.lower().replace("-", "").replace("_", "")


class TextIOWrapper(_SystemFile, TextIOBase):
    """Text of a file of the system."""
    __module__ = "_io"

    def __init__(self, file, name, mode, reads, writes, encoding, errors, newline, by_line):
        self._open(file, name, mode, reads, writes)
        self.encoding = encoding
        self.errors = errors
        self.newlines = None
        self.line_buffering = by_line
        self._utf8 = _plain(encoding) in _UTF8
        self._ends = "any" if newline in (None, "") else newline
        self._translates = newline is None
        self._written = newline if newline in ("\r", "\r\n") else None

    def __repr__(self):
        return f"<_io.TextIOWrapper name={self._name!r} mode={self._mode!r} encoding={self.encoding!r}>"

    def _take(self, size, line):
        if self.closed:
            raise ValueError("I/O operation on closed file.")
        if not self._reads:
            raise UnsupportedOperation("not readable")
        data = self._file.read_text(size, self._utf8, self._ends, line, self._translates)
        self._at_end = not data
        text = data.decode(self.encoding, self.errors)
        if self._translates and "\r" in text:
            text = text.replace("\r\n", "\n").replace("\r", "\n")
        return text

    def read(self, size=-1, /):
        text = self._take(-1 if size is None else size, False)
        # Characters that the handler of errors leaves out do not count.
        while self.errors == "ignore" and size is not None and len(text) < size:
            text += self._take(size - len(text), False)
            if self._at_end:
                break
        return text

    def readline(self, size=-1, /):
        return self._take(size, True)

    def __next__(self):
        line = self._take(-1, True)
        if not line:
            raise StopIteration
        return line

    def write(self, text, /):
        if not isinstance(text, str):
            raise TypeError(f"write() argument must be str, not {type(text).__name__}")
        if self.closed:
            raise ValueError("I/O operation on closed file.")
        if not self._writes:
            raise UnsupportedOperation("not writable")
        shown = text if self._written is None else text.replace("\n", self._written)
        self._file.write(shown.encode(self.encoding, self.errors))
        if self.line_buffering and "\n" in text:
            self._file.flush()
        return len(text)

    def seek(self, cookie, whence=SEEK_SET, /):
        self._check()
        if whence == SEEK_CUR and cookie != 0:
            raise UnsupportedOperation("can't do nonzero cur-relative seeks")
        if whence == SEEK_END and cookie != 0:
            raise UnsupportedOperation("can't do nonzero end-relative seeks")
        if whence == SEEK_SET and cookie < 0:
            raise ValueError(f"negative seek position {cookie!r}")
        return self._file.seek(cookie, whence)

    def reconfigure(self, *, line_buffering=None):
        if line_buffering is not None:
            self.line_buffering = line_buffering


class _EncodedText(TextIOWrapper):
    """Text in an encoding whose characters or lines are not to be found in the bytes: it is read as a whole, from where
    the file stands when it is first read; so places in it are those of the text."""

    def __init__(self, file, name, mode, reads, writes, encoding, errors, newline, by_line):
        from codecs import lookup
        found = lookup(encoding)
        super().__init__(file, name, mode, reads, writes, encoding, errors, newline, by_line)
        self._encoder, self._decoder = found.incrementalencoder(errors), found.incrementaldecoder(errors)
        self._keeps = newline
        self._text, self._at = None, 0
        if writes and file.tell():
            self._encoder.setstate(1)

    def _take(self, size, line):
        if self.closed:
            raise ValueError("I/O operation on closed file.")
        if not self._reads:
            raise UnsupportedOperation("not readable")
        if self._text is None:
            text = self._decoder.decode(self._file.read(-1), True)
            if self._translates:
                text = text.replace("\r\n", "\n").replace("\r", "\n")
            self._text = text
        start, end = self._at, len(self._text)
        if line:
            end = self._end_of_line(start)
        if size is not None and size >= 0:
            end = min(end, start + size)
        self._at = end
        self._at_end = start == end
        return self._text[start:end]

    def _end_of_line(self, start):
        text = self._text
        if self._keeps != "":
            feed = self._keeps or "\n"
            at = text.find(feed, start)
            return len(text) if at < 0 else at + len(feed)
        ends = [at for at in (text.find("\n", start), text.find("\r", start)) if at >= 0]
        if not ends:
            return len(text)
        at = min(ends)
        return at + 2 if text[at:at + 2] == "\r\n" else at + 1

    def read(self, size=-1, /):
        return self._take(size, False)

    def write(self, text, /):
        if not isinstance(text, str):
            raise TypeError(f"write() argument must be str, not {type(text).__name__}")
        if self.closed:
            raise ValueError("I/O operation on closed file.")
        if not self._writes:
            raise UnsupportedOperation("not writable")
        shown = text if self._written is None else text.replace("\n", self._written)
        self._file.write(self._encoder.encode(shown))
        if self.line_buffering and "\n" in text:
            self._file.flush()
        return len(text)

    def tell(self):
        self._check()
        return self._file.tell() if self._text is None else self._at

    def seek(self, cookie, whence=SEEK_SET, /):
        self._check()
        if cookie != 0:
            raise UnsupportedOperation(f"seeks in text of {self.encoding} go to its ends only")
        if whence == SEEK_CUR:
            return self.tell()
        if self._text is not None:
            if whence == SEEK_END:
                self._at = len(self._text)
                return self._at
            self._text, self._at = None, 0
        self._decoder.reset()
        place = self._file.seek(0, whence)
        self._encoder.setstate(int(place > 0))
        return place


def open(file, mode="r", buffering=-1, encoding=None, errors=None, newline=None, closefd=True, opener=None):
    if not isinstance(mode, str):
        raise TypeError(f"open() argument 'mode' must be str, not {type(mode).__name__}")
    letters = set(mode)
    if letters - set("axrwb+t") or len(mode) > len(letters):
        raise ValueError(f"invalid mode: {mode!r}")
    binary = "b" in letters
    if binary and "t" in letters:
        raise ValueError("can't have text and binary mode at once")
    kind = letters & set("axrw")
    if not kind:
        raise ValueError("Must have exactly one of create/read/write/append mode and at most one plus")
    if len(kind) > 1:
        raise ValueError("must have exactly one of create/read/write/append mode")
    for value, word in ((encoding, "an encoding"), (errors, "an errors"), (newline, "a newline")):
        if binary and value is not None:
            raise ValueError(f"binary mode doesn't take {word} argument")
    if newline not in (None, "", "\n", "\r", "\r\n"):
        raise ValueError(f"illegal newline value: {newline}")
    if not binary and buffering == 0:
        raise ValueError("can't have unbuffered text I/O")
    if opener is not None:
        raise UnsupportedOperation("open() with an opener is not supported")
    (kind,) = kind
    reads = kind == "r" or "+" in letters
    writes = kind != "r" or "+" in letters
    if isinstance(file, int):
        own = _descriptor(file)
    else:
        if not isinstance(file, (str, bytes)):
            file = _path(file)
        own = _files.open(_path(file), kind + ("+" if "+" in letters else ""))
    if kind == "a":
        own.seek(0, 2)
    if not binary:
        encoding = encoding or "UTF-8"
        face = TextIOWrapper if _plain(encoding) in _UTF8 + _BYTES else _EncodedText
        return face(own, file, mode, reads, writes, encoding, errors or "strict", newline, buffering == 1)
    if buffering == 0:
        face = FileIO
    elif "+" in letters:
        face = BufferedRandom
    else:
        face = BufferedReader if reads else BufferedWriter
    return face(own, file, mode, reads, writes, buffering == 0)


def _path(path):
    """Text of a path that may be text, bytes or an object with `__fspath__`."""
    if not isinstance(path, (str, bytes)):
        convert = getattr(type(path), "__fspath__", None)
        if convert is None:
            raise TypeError(f"expected str, bytes or os.PathLike object, not {type(path).__name__}")
        path = convert(path)
    return path.decode() if isinstance(path, bytes) else path


# Numbers of open files, for `os`; only files that were asked for theirs have one.
_descriptors = {}


def _enter(file):
    number = 3
    while number in _descriptors:
        number += 1
    _descriptors[number] = file
    return number


def _descriptor(number):
    file = _descriptors.get(number)
    if file is None:
        raise OSError(9, "Bad file descriptor")
    return file


class _MemoryFile:
    """A position in a text or in bytes."""

    def _start(self, initial, empty):
        self._data = initial
        self._empty = empty
        # What was written at the end and is not joined yet.
        self._parts = []
        self._length = len(initial)
        self._at = 0
        self._open = True

    closed = property(lambda self: not self._open)

    def readable(self):
        return True

    writable = seekable = readable

    def _whole(self):
        if self._parts:
            self._data += self._empty.join(self._parts)
            self._parts = []
        return self._data

    def getvalue(self):
        self._check()
        return self._whole()

    def close(self):
        self._open = False
        self._data = self._empty
        self._parts = []

    def tell(self):
        self._check()
        return self._at

    def read(self, size=-1, /):
        self._check()
        data = self._whole()
        start = self._at
        end = self._length if size is None or size < 0 else min(start + size, self._length)
        self._at = max(start, end)
        return data[start:end]

    def _line(self, size, feed):
        self._check()
        data = self._whole()
        start = self._at
        end = data.find(feed, start) + 1 or self._length
        if size is not None and size >= 0:
            end = min(end, start + size)
        self._at = max(start, end)
        return data[start:end]

    def _put(self, data, filler):
        if not data:
            return 0
        if self._at == self._length:
            self._parts.append(data)
        else:
            whole = self._whole()
            if self._at > self._length:
                whole += filler * (self._at - self._length)
            self._data = whole[:self._at] + data + whole[self._at + len(data):]
        self._at += len(data)
        self._length = max(self._length, self._at)
        return len(data)

    def truncate(self, size=None, /):
        self._check()
        size = self._at if size is None else size
        if size < 0:
            raise ValueError(f"negative size value {size}")
        self._data = self._whole()[:size]
        self._length = len(self._data)
        return size


class StringIO(_MemoryFile, TextIOBase):
    """Text in memory."""
    __module__ = "_io"
    encoding = errors = newlines = None

    def _check(self):
        if not self._open:
            raise ValueError("I/O operation on closed file")

    def __init__(self, initial_value="", newline="\n"):
        if initial_value is not None and not isinstance(initial_value, str):
            raise TypeError(f"initial_value must be str or None, not {type(initial_value).__name__}")
        if newline not in ("\n", None, ""):
            raise ValueError("StringIO keeps newlines as they are here: newline must be '\\n', '' or None")
        text = initial_value or ""
        self._translates = newline is None
        self._start(self._translated(text), "")

    def _translated(self, text):
        return text.replace("\r\n", "\n").replace("\r", "\n") if self._translates else text

    def readline(self, size=-1, /):
        return self._line(size, "\n")

    def write(self, text, /):
        if not isinstance(text, str):
            raise TypeError(f"string argument expected, got {type(text).__name__!r}")
        self._check()
        self._put(self._translated(text), "\0")
        return len(text)

    def seek(self, pos, whence=SEEK_SET, /):
        self._check()
        if whence not in (0, 1, 2):
            raise ValueError(f"Invalid whence ({whence}, should be 0, 1 or 2)")
        if whence == SEEK_SET and pos < 0:
            raise ValueError(f"Negative seek position {pos}")
        if whence != SEEK_SET and pos != 0:
            raise OSError("Can't do nonzero cur-relative seeks")
        self._at = (pos, self._at, self._length)[whence]
        return self._at


class BytesIO(_MemoryFile, BufferedIOBase):
    """Bytes in memory."""
    __module__ = "_io"

    def __init__(self, initial_bytes=b""):
        self._start(bytearray() if initial_bytes is None else bytearray(_bytes_of(initial_bytes)), b"")

    def close(self):
        self._open = False
        self._data = bytearray()

    def getvalue(self):
        self._check()
        return bytes(self._data)

    getbuffer = getvalue

    def read(self, size=-1, /):
        self._check()
        return bytes(_MemoryFile.read(self, size))

    read1 = read

    def readline(self, size=-1, /):
        return bytes(self._line(size, b"\n"))

    def readinto(self, buffer, /):
        _check_room(buffer)
        data = self.read(len(buffer))
        buffer[:len(data)] = data
        return len(data)

    def write(self, data, /):
        self._check()
        data = _bytes_of(data)
        if not data:
            return 0
        if self._at > self._length:
            self._data += bytes(self._at - self._length)
        end = self._at + len(data)
        self._data[self._at:end] = data
        self._at = end
        self._length = len(self._data)
        return len(data)

    def truncate(self, size=None, /):
        self._check()
        size = self._at if size is None else size
        if size < 0:
            raise ValueError(f"negative size value {size}")
        del self._data[size:]
        self._length = len(self._data)
        return size

    def seek(self, pos, whence=SEEK_SET, /):
        self._check()
        if whence == SEEK_SET and pos < 0:
            raise ValueError(f"negative seek value {pos}")
        self._at = max(0, (0, self._at, self._length)[whence] + pos)
        return self._at
