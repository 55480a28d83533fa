"""Other processes. Starting them needs the permission of the controller.

A process has a group of its own, which is killed at the end of the task. Waiting for it lets other threads go on, and
ends at once when the program is stopped."""
import _process
import io as _io
from time import monotonic as _now

PIPE = -1
STDOUT = -2
DEVNULL = -3


class SubprocessError(Exception):
    pass


class CalledProcessError(SubprocessError):
    def __init__(self, returncode, cmd, output=None, stderr=None):
        super().__init__(returncode, cmd)
        self.returncode = returncode
        self.cmd = cmd
        self.output = self.stdout = output
        self.stderr = stderr

    def __str__(self):
        if self.returncode < 0:
            import signal
            try:
                return f"Command '{self.cmd}' died with {signal.Signals(-self.returncode)!r}."
            except ValueError:
                return f"Command '{self.cmd}' died with unknown signal {-self.returncode}."
        return f"Command '{self.cmd}' returned non-zero exit status {self.returncode}."


class TimeoutExpired(SubprocessError):
    def __init__(self, cmd, timeout, output=None, stderr=None):
        super().__init__(cmd, timeout)
        self.cmd = cmd
        self.timeout = timeout
        self.output = self.stdout = output
        self.stderr = stderr

    def __str__(self):
        return f"Command '{self.cmd}' timed out after {self.timeout} seconds"


class CompletedProcess:
    def __init__(self, args, returncode, stdout=None, stderr=None):
        self.args = args
        self.returncode = returncode
        self.stdout = stdout
        self.stderr = stderr

    def check_returncode(self):
        if self.returncode:
            raise CalledProcessError(self.returncode, self.args, self.stdout, self.stderr)

    def __repr__(self):
        parts = [f"args={self.args!r}", f"returncode={self.returncode!r}"]
        if self.stdout is not None:
            parts.append(f"stdout={self.stdout!r}")
        if self.stderr is not None:
            parts.append(f"stderr={self.stderr!r}")
        return f"CompletedProcess({', '.join(parts)})"


class _Text:
    """How bytes of a pipe become text."""

    def __init__(self, encoding, errors):
        self.encoding = encoding or "utf-8"
        self.errors = errors or "strict"

    def shown(self, data):
        return data.decode(self.encoding, self.errors).replace("\r\n", "\n").replace("\r", "\n")


class _Reader(_io.IOBase):
    """What a process writes."""

    def __init__(self, process, errors, text):
        self._process = process
        self._errors = errors
        self._text = text
        self._pending = b""
        self._open = True
        self._ended = False

    closed = property(lambda self: not self._open)

    def readable(self):
        return True

    def close(self):
        self._open = False

    def _more(self):
        """Waits for more; false at the end."""
        while not self._ended:
            seen = self._process.news()
            data = self._process.read(self._errors, 65536)
            if data:
                self._pending += data
                return True
            if data is not None:
                self._ended = True
            else:
                self._process.wait(seen, None)
        return False

    def _take(self, count):
        data, self._pending = self._pending[:count], self._pending[count:]
        return data if self._text is None else self._text.shown(data)

    def read(self, size=-1, /):
        self._check()
        if size is None or size < 0:
            parts = [self._pending]
            self._pending = b""
            while self._more():
                parts.append(self._pending)
                self._pending = b""
            self._pending = b"".join(parts)
            return self._take(len(self._pending))
        while len(self._pending) < size and self._more():
            pass
        return self._take(size)

    def readline(self, size=-1, /):
        self._check()
        while b"\n" not in self._pending and self._more():
            pass
        end = self._pending.find(b"\n") + 1 or len(self._pending)
        return self._take(end if size is None or size < 0 else min(end, size))


class _Writer(_io.IOBase):
    """What a process reads."""

    def __init__(self, process, text):
        self._process = process
        self._text = text
        self._open = True

    closed = property(lambda self: not self._open)

    def writable(self):
        return True

    def write(self, data, /):
        self._check()
        sent = data if self._text is None else data.encode(self._text.encoding, self._text.errors)
        start = 0
        while start < len(sent):
            seen = self._process.news()
            count = self._process.write(sent, start)
            if count is None:
                self._process.wait(seen, None)
            else:
                start += count
        return len(data)

    def close(self):
        if self._open:
            self._open = False
            self._process.close_input()


class Popen:
    """A process that runs beside the program."""

    def __init__(self, args, bufsize=-1, executable=None, stdin=None, stdout=None, stderr=None, preexec_fn=None,
                 close_fds=True, shell=False, cwd=None, env=None, universal_newlines=None, startupinfo=None,
                 creationflags=0, restore_signals=True, start_new_session=False, pass_fds=(), *, user=None, group=None,
                 extra_groups=None, encoding=None, errors=None, text=None, umask=-1, pipesize=-1, process_group=None):
        refused = (("preexec_fn", preexec_fn), ("executable", executable), ("pass_fds", pass_fds), ("user", user),
                   ("group", group), ("extra_groups", extra_groups))
        for name, value in refused:
            if value:
                raise ValueError(f"{name} is not supported on the controller")
        self.args = args
        self.returncode = None
        is_text = text or universal_newlines or encoding or errors
        self._text = _Text(encoding, errors) if is_text else None
        words = [args] if isinstance(args, (str, bytes)) or hasattr(args, "__fspath__") else list(args)
        words = [_io._path(word) for word in words]
        if shell:
            words = ["/bin/sh", "-c"] + words
        import os
        if env is None and os.environ._own is not None:
            env = os.environ._own
        elif env is not None:
            env = {_io._path(name): _io._path(value) for name, value in env.items()}
        self._process = process = _process.spawn(words, None if cwd is None else _io._path(cwd), env, _stream(stdin),
                                                 _stream(stdout), _stream(stderr))
        self.pid = process.number()
        self.stdin = _Writer(process, self._text) if stdin == PIPE else None
        self.stdout = _Reader(process, False, self._text) if stdout == PIPE else None
        self.stderr = _Reader(process, True, self._text) if stderr == PIPE else None

    def __enter__(self):
        return self

    def __exit__(self, *args):
        for stream in (self.stdout, self.stderr, self.stdin):
            if stream is not None:
                stream.close()
        self.wait()

    def __repr__(self):
        return f"<Popen: returncode: {self.returncode} args: {self.args!r}>"

    def poll(self):
        if self.returncode is None:
            self.returncode = self._process.ended()
        return self.returncode

    def wait(self, timeout=None):
        deadline = None if timeout is None else _now() + timeout
        while True:
            seen = self._process.news()
            if self.poll() is not None:
                return self.returncode
            if deadline is not None and _now() >= deadline:
                raise TimeoutExpired(self.args, timeout)
            self._process.wait(seen, deadline)

    def communicate(self, input=None, timeout=None):
        deadline = None if timeout is None else _now() + timeout
        if self.stdin is not None and input:
            data = input if self._text is None else input.encode(self._text.encoding, self._text.errors)
        else:
            data = b""
        start = 0
        if self.stdin is not None and not data:
            self.stdin.close()
        readers = [reader for reader in (self.stdout, self.stderr) if reader is not None]
        while True:
            seen = self._process.news()
            moved = False
            if start < len(data):
                try:
                    count = self._process.write(data, start)
                except BrokenPipeError:
                    count = len(data) - start
                if count is not None:
                    start += count
                    moved = True
                    if start == len(data):
                        self.stdin.close()
            for reader in readers:
                if not reader._ended:
                    piece = self._process.read(reader._errors, 65536)
                    if piece:
                        reader._parts = getattr(reader, "_parts", [])
                        reader._parts.append(piece)
                        moved = True
                    elif piece is not None:
                        reader._ended = moved = True
            if start == len(data) and all(reader._ended for reader in readers) and self.poll() is not None:
                break
            if deadline is not None and _now() >= deadline:
                so_far = [self._collected(reader, True) for reader in (self.stdout, self.stderr)]
                raise TimeoutExpired(self.args, timeout, *so_far)
            if not moved:
                self._process.wait(seen, deadline)
        return self._collected(self.stdout), self._collected(self.stderr)

    def _collected(self, reader, raw=False):
        if reader is None:
            return None
        data = reader._pending + b"".join(getattr(reader, "_parts", []))
        if raw:
            return data or None
        reader.close()
        return data if self._text is None else self._text.shown(data)

    def send_signal(self, signal):
        if self.poll() is None:
            self._process.signal(int(signal))

    def terminate(self):
        self.send_signal(15)

    def kill(self):
        self.send_signal(9)


def _stream(stream):
    """How the native part knows a standard stream."""
    if stream is None:
        return "inherit"
    if isinstance(stream, int):
        words = {PIPE: "pipe", DEVNULL: "null", STDOUT: "output"}
        return words[stream] if stream in words else _io._descriptor(stream)
    file = getattr(stream, "_file", None)
    if file is None:
        return _io._descriptor(stream.fileno())
    return file


def run(*popenargs, input=None, capture_output=False, timeout=None, check=False, **kwargs):
    if input is not None:
        if kwargs.get("stdin") is not None:
            raise ValueError("stdin and input arguments may not both be used.")
        kwargs["stdin"] = PIPE
    if capture_output:
        if kwargs.get("stdout") is not None or kwargs.get("stderr") is not None:
            raise ValueError("stdout and stderr arguments may not be used with capture_output.")
        kwargs["stdout"] = kwargs["stderr"] = PIPE
    process = Popen(*popenargs, **kwargs)
    try:
        stdout, stderr = process.communicate(input, timeout)
    except BaseException:
        process.kill()
        raise
    if check and process.returncode:
        raise CalledProcessError(process.returncode, process.args, stdout, stderr)
    return CompletedProcess(process.args, process.returncode, stdout, stderr)


def call(*popenargs, timeout=None, **kwargs):
    process = Popen(*popenargs, **kwargs)
    try:
        return process.wait(timeout)
    except BaseException:
        process.kill()
        raise


def check_call(*popenargs, **kwargs):
    code = call(*popenargs, **kwargs)
    if code:
        raise CalledProcessError(code, popenargs[0] if popenargs else kwargs.get("args"))
    return 0


def check_output(*popenargs, timeout=None, **kwargs):
    for name in ("stdout", "check"):
        if name in kwargs:
            raise ValueError(f"{name} argument not allowed, it will be overridden.")
    if kwargs.get("input", ...) is None:
        kwargs["input"] = "" if kwargs.get("text") or kwargs.get("universal_newlines") else b""
    return run(*popenargs, stdout=PIPE, timeout=timeout, check=True, **kwargs).stdout


def getstatusoutput(cmd, *, encoding=None, errors=None):
    done = run(cmd, shell=True, text=True, stdout=PIPE, stderr=STDOUT, encoding=encoding, errors=errors)
    return done.returncode, done.stdout.removesuffix("\n")


def getoutput(cmd, *, encoding=None, errors=None):
    return getstatusoutput(cmd, encoding=encoding, errors=errors)[1]


def list2cmdline(seq):
    import re
    words = []
    for word in map(_io._path, seq):
        quoted = re.sub(r'(\\*)"', r'\1\1\\"', word)
        if not word or " " in word or "\t" in word:
            quoted = '"' + quoted + '"'
        words.append(quoted)
    return " ".join(words)


class _Shell:
    """`os.popen`: one end of the pipes of a shell's command."""

    def __init__(self, process, stream):
        self._popen = process
        self._stream = stream

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def __enter__(self):
        return self

    def __exit__(self, *args):
        self.close()

    def __iter__(self):
        return iter(self._stream)

    def close(self):
        self._stream.close()
        code = self._popen.wait()
        return None if code == 0 else -code if code < 0 else code << 8


def _popen(command, mode):
    if mode == "r":
        process = Popen(command, shell=True, text=True, stdout=PIPE)
        return _Shell(process, process.stdout)
    process = Popen(command, shell=True, text=True, stdin=PIPE)
    return _Shell(process, process.stdin)
