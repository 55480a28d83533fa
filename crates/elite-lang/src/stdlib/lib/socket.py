"""TCP sockets: AF_INET and SOCK_STREAM, as client and server."""
from _socket import Socket as _Socket

AF_UNSPEC = 0
AF_UNIX = 1
AF_INET = 2
AF_INET6 = 10
SOCK_STREAM = 1
SOCK_DGRAM = 2
IPPROTO_IP = 0
IPPROTO_TCP = 6
IPPROTO_UDP = 17
SOL_SOCKET = 1
SO_REUSEADDR = 2
SO_ERROR = 4
SO_BROADCAST = 6
SO_SNDBUF = 7
SO_RCVBUF = 8
SO_KEEPALIVE = 9
SO_LINGER = 13
SO_REUSEPORT = 15
TCP_NODELAY = 1
TCP_KEEPIDLE = 4
TCP_KEEPINTVL = 5
TCP_KEEPCNT = 6
SHUT_RD = 0
SHUT_WR = 1
SHUT_RDWR = 2
SOMAXCONN = 4096
INADDR_ANY = 0
MSG_PEEK = 2
has_ipv6 = False

error = OSError
timeout = TimeoutError


class gaierror(OSError):
    pass


class herror(OSError):
    pass


_default_timeout = None
_number = 2
# Options that change nothing a program could see here.
_WITHOUT_EFFECT = ((SOL_SOCKET, SO_REUSEADDR), (SOL_SOCKET, SO_REUSEPORT), (SOL_SOCKET, SO_KEEPALIVE),
                   (SOL_SOCKET, SO_SNDBUF), (SOL_SOCKET, SO_RCVBUF), (SOL_SOCKET, SO_LINGER),
                   (IPPROTO_TCP, TCP_KEEPIDLE), (IPPROTO_TCP, TCP_KEEPINTVL), (IPPROTO_TCP, TCP_KEEPCNT))


class socket:
    def __init__(self, family=AF_INET, type=SOCK_STREAM, proto=0, fileno=None, *, _own=None):
        global _number
        if family not in (AF_INET, -1) or type not in (SOCK_STREAM, -1) or proto not in (0, IPPROTO_TCP, -1):
            raise OSError(97, "only AF_INET sockets of type SOCK_STREAM are supported")
        if fileno is not None:
            raise OSError(9, "sockets cannot be made from a file descriptor")
        self._own = _Socket() if _own is None else _own
        self._own.settimeout(_default_timeout)
        self._options = {}
        _number += 1
        self._fileno = _number

    family = property(lambda self: AF_INET)
    type = property(lambda self: SOCK_STREAM)
    proto = property(lambda self: 0)

    def __enter__(self):
        return self

    def __exit__(self, *args):
        self.close()

    def __repr__(self):
        state = "[closed] " if self._own.closed() else ""
        return f"<socket.socket {state}fd={self.fileno()}, family=2, type=1, proto=0>"

    def connect(self, address):
        self._own.connect(address)

    def connect_ex(self, address):
        try:
            self._own.connect(address)
        except OSError as e:
            return e.errno if e.errno is not None else 11
        return 0

    def bind(self, address):
        self._own.bind(address)

    def listen(self, backlog=128):
        self._own.listen(backlog)

    def accept(self):
        own, address = self._own.accept()
        return socket(_own=own), address

    def recv(self, bufsize, flags=0):
        if flags:
            raise OSError(95, "flags of recv() are not supported")
        return self._own.recv(bufsize)

    def recv_into(self, buffer, nbytes=0, flags=0):
        data = self.recv(nbytes or len(buffer), flags)
        buffer[:len(data)] = data
        return len(data)

    def recvfrom(self, bufsize, flags=0):
        return self.recv(bufsize, flags), None

    def send(self, data, flags=0):
        return self._own.send(data)

    def sendall(self, data, flags=0):
        self._own.sendall(data)

    def shutdown(self, how):
        self._own.shutdown(how)

    def close(self):
        self._own.close()

    def detach(self):
        raise OSError(95, "detach() is not supported")

    def settimeout(self, value):
        self._own.settimeout(value)

    def gettimeout(self):
        return self._own.gettimeout()

    timeout = property(gettimeout)

    def setblocking(self, flag):
        self._own.settimeout(None if flag else 0.0)

    def getblocking(self):
        return self._own.gettimeout() != 0.0

    def setsockopt(self, level, optname, value, optlen=None):
        if (level, optname) == (IPPROTO_TCP, TCP_NODELAY):
            self._own.setnodelay(value)
        elif (level, optname) not in _WITHOUT_EFFECT:
            raise OSError(92, "Protocol not available")
        self._options[level, optname] = value

    def getsockopt(self, level, optname, buflen=0):
        return self._options.get((level, optname), 0)

    def getsockname(self):
        return self._own.getsockname()

    def getpeername(self):
        return self._own.getpeername()

    def fileno(self):
        return -1 if self._own.closed() else self._fileno

    def makefile(self, mode="r", buffering=None, *, encoding=None, errors=None, newline=None):
        for letter in mode:
            if letter not in "rwb":
                raise ValueError(f"invalid mode {mode!r} (only r, w, b allowed)")
        return _File(self, mode, encoding or "utf-8")


SocketType = socket


class _File:
    """A socket as a file, with text or bytes."""

    def __init__(self, sock, mode, encoding):
        self._sock = sock
        self.mode = mode
        self.encoding = encoding
        self.closed = False
        self._text = "b" not in mode
        self._pending = b""

    def __enter__(self):
        return self

    def __exit__(self, *args):
        self.close()

    def __iter__(self):
        return self

    def __next__(self):
        line = self.readline()
        if not line:
            raise StopIteration
        return line

    def readable(self):
        return "r" in self.mode

    def writable(self):
        return "w" in self.mode

    def _check(self):
        if self.closed:
            raise ValueError("I/O operation on closed file.")

    def _shown(self, data):
        return data.decode(self.encoding).replace("\r\n", "\n") if self._text else data

    def readline(self, limit=-1):
        self._check()
        while b"\n" not in self._pending and (limit < 0 or len(self._pending) < limit):
            data = self._sock.recv(8192)
            if not data:
                break
            self._pending += data
        end = self._pending.find(b"\n") + 1 or len(self._pending)
        if limit >= 0:
            end = min(end, limit)
        line, self._pending = self._pending[:end], self._pending[end:]
        return self._shown(line)

    def readlines(self):
        return list(self)

    def read(self, size=-1):
        self._check()
        size = -1 if size is None else size
        while size < 0 or len(self._pending) < size:
            data = self._sock.recv(8192)
            if not data:
                break
            self._pending += data
        if size < 0:
            size = len(self._pending)
        data, self._pending = self._pending[:size], self._pending[size:]
        return self._shown(data)

    def write(self, data):
        self._check()
        self._sock.sendall(data.encode(self.encoding) if self._text else data)
        return len(data)

    def writelines(self, lines):
        for line in lines:
            self.write(line)

    def flush(self):
        pass

    def close(self):
        self.closed = True


def create_connection(address, timeout=..., source_address=None, *, all_errors=False):
    sock = socket()
    try:
        if timeout is not ...:
            sock.settimeout(timeout)
        if source_address:
            sock.bind(source_address)
        sock.connect(address)
    except BaseException:
        sock.close()
        raise
    return sock


def create_server(address, *, family=AF_INET, backlog=None, reuse_port=False, dualstack_ipv6=False):
    sock = socket(family)
    try:
        sock.bind(address)
        sock.listen(128 if backlog is None else backlog)
    except BaseException:
        sock.close()
        raise
    return sock


def getdefaulttimeout():
    return _default_timeout


def setdefaulttimeout(timeout):
    global _default_timeout
    _default_timeout = timeout


def gethostname():
    return "elite"


def htons(x):
    return int.from_bytes(x.to_bytes(2, "big"), "little")


def htonl(x):
    return int.from_bytes(x.to_bytes(4, "big"), "little")


ntohs = htons
ntohl = htonl


def inet_aton(ip_string):
    parts = ip_string.split(".")
    if len(parts) != 4 or not all(part.isdigit() and int(part) < 256 for part in parts):
        raise OSError("illegal IP address string passed to inet_aton")
    return bytes(int(part) for part in parts)


def inet_ntoa(packed_ip):
    if len(packed_ip) != 4:
        raise OSError("packed IP wrong length")
    return ".".join(str(part) for part in packed_ip)
