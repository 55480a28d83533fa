import os
data = bytes(range(256)) * 100
with open('b.bin', 'wb') as f:
    print(f.write(data), f.tell(), f.mode, f.name)
with open('b.bin', 'rb') as f:
    print(f.read(4), f.tell(), f.seek(10, 1), f.read(2), f.seek(-3, 2), f.read(), f.read(), f.peek(4))
    print(f.seek(0), len(f.readline()), f.read(1))
    b = bytearray(5)
    print(f.readinto(b), b)
    print(f.seek(0), f.read() == data, f.read(-1))
with open('b.bin', 'r+b') as f:
    f.seek(100)
    f.write(b'HELLO')
    print(f.tell(), f.read(3), f.tell())
    f.seek(98)
    print(f.read(10))
    f.write(b'again')
    print(f.seek(98), f.read(20))
    print(f.truncate(200), f.tell(), f.seek(0, 2))
with open('b.bin', 'ab') as f:
    f.write(b'end'); print(f.tell())
with open('b.bin', 'w+b') as f:
    f.write(b'abc\ndef\nghi'); f.seek(0)
    print(list(f), f.tell())
f = open('b.bin', 'rb')
for bad in (lambda: f.write(b'x'), lambda: f.seek(-1), lambda: f.seek(0, 5), lambda: f.truncate()):
    try: bad()
    except (OSError, ValueError) as e: print(type(e).__name__, e)
f.close()
for bad in (f.read, f.readline, lambda: f.write(b'')):
    try: bad()
    except ValueError as e: print(e)
w = open('w.bin', 'wb', buffering=0)
w.write(b'at once')
print(os.path.getsize('w.bin'))
for bad in (w.read, lambda: w.write('text'), lambda: w.write(5)):
    try: bad()
    except (OSError, TypeError) as e: print(type(e).__name__)
w.write(bytearray(b'!')); w.close()
v = open('v.bin', 'wb')
v.write(b'x' * 100)
print(os.path.getsize('v.bin'))
v.flush()
print(os.path.getsize('v.bin'))
v.close()
import struct
with open('s.bin', 'wb') as f:
    for i in range(3): f.write(struct.pack('<if', i, i / 2))
with open('s.bin', 'rb') as f:
    while chunk := f.read(8): print(struct.unpack('<if', chunk))
fd = os.open('low.bin', os.O_RDWR | os.O_CREAT)
print(os.write(fd, b'hello'), os.lseek(fd, 1, os.SEEK_SET), os.read(fd, 3), os.fstat(fd).st_size)
os.fsync(fd); os.ftruncate(fd, 2); os.close(fd)
print(open('low.bin', 'rb').read())
try: os.close(999)
except OSError as e: print(e)
try: os.open('low.bin', os.O_CREAT | os.O_EXCL | os.O_WRONLY)
except FileExistsError as e: print(e)
with os.fdopen(os.open('low.bin', os.O_RDONLY)) as f: print(f.read())
