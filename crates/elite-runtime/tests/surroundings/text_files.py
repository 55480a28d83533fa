import io, os
with open('a.txt', 'w') as f:
    print(f.write('first\nzweite Zeile ü\n'), f.name, f.mode, f.encoding, f.closed, f.writable(), f.readable())
    f.writelines(['third\n', '位置\n'])
    print('printed', 1, 2.5, file=f)
print(f.closed, os.path.getsize('a.txt'))
with open('a.txt') as f:
    print([line for line in f])
with open('a.txt') as f:
    print(repr(f.readline()), repr(f.read(3)), repr(f.readline()), f.readlines())
    print(repr(f.read()), repr(f.readline()))
    f.seek(0)
    print(f.read())
    print(f.seek(0, 2), f.tell())
with open('a.txt', 'a') as f:
    print(f.tell())
    f.write('end')
with open('a.txt', 'r+') as f:
    print(f.readline())
    f.seek(0)
    f.write('FIRST')
    f.seek(0)
    print(f.read())
    print(f.truncate(5))
print(open('a.txt').read())
with open('x.txt', 'x') as f: f.write('new')
try: open('x.txt', 'x')
except FileExistsError as e: print(e, e.errno, e.filename, e.strerror)
try: open('nowhere/x.txt')
except FileNotFoundError as e: print(e, e.errno, e.filename)
try: open('.')
except IsADirectoryError as e: print(e)
for mode in ('q', 'rw', 'rbt', '', 'rr', 'r+w', 'b'):
    try: open('a.txt', mode)
    except ValueError as e: print(e)
for keywords in (dict(mode='rb', encoding='utf-8'), dict(mode='rb', newline=''), dict(mode='rb', errors='strict'),
                 dict(newline='x'), dict(buffering=0)):
    try: open('a.txt', **keywords)
    except ValueError as e: print(e)
f = open('a.txt')
for bad in (lambda: f.write('x'), lambda: f.seek(1, 1), lambda: f.seek(-1)):
    try: bad()
    except (ValueError, OSError) as e: print(type(e).__name__, e)
f.close()
f.close()
for bad in (f.read, f.readline, lambda: list(f), lambda: f.write('x'), f.tell, f.flush, f.__enter__):
    try: bad()
    except ValueError as e: print(e)
g = open('a.txt', 'w')
for bad in (g.read, g.readline, lambda: g.write(b'x'), lambda: g.write(5), lambda: next(g)):
    try: bad()
    except (ValueError, TypeError, OSError) as e: print(type(e).__name__, e)
g.close()
with open('n.txt', 'wb') as f: f.write(b'a\r\nb\rc\nd\r\n\r\n\xc3\xbc')
for newline in (None, '', '\n', '\r', '\r\n'):
    with open('n.txt', newline=newline) as f: print(newline, f.readlines())
    with open('n.txt', newline=newline) as f: print([f.read(1) for _ in range(12)])
for newline in (None, '', '\n', '\r', '\r\n'):
    with open('m.txt', 'w', newline=newline) as f: f.write('1\n2\r\n3')
    print(open('m.txt', 'rb').read())
for encoding in ('latin-1', 'ascii', 'utf-8'):
    try:
        with open('e.txt', 'w', encoding=encoding) as f: f.write('ü\nx')
        print(encoding, open('e.txt', 'rb').read(), open('e.txt', encoding=encoding).read())
    except UnicodeEncodeError as e: print(e)
with open('bad.txt', 'wb') as f: f.write(b'ok\n\xff\xfe\nlast\n')
try: open('bad.txt').read()
except UnicodeDecodeError as e: print(e.reason)
print(open('bad.txt', errors='replace').readlines(), open('bad.txt', errors='ignore').read(4))
big = [f'line {i} ü\n' for i in range(5000)]
with open('big.txt', 'w') as f: f.writelines(big)
print(open('big.txt').readlines() == big, sum(1 for _ in open('big.txt')))
with open('big.txt') as f:
    parts = []
    while True:
        part = f.read(777)
        if not part: break
        parts.append(part)
    print(''.join(parts) == ''.join(big), len(parts))
with open('big.txt') as f: print(f.readlines(30), f.readline(4), f.readline(-1))
s = io.StringIO('one\ntwo\n')
print(s.readline(), s.tell(), s.read(), s.getvalue(), list(io.StringIO('a\nb')))
s = io.StringIO()
print('x', 'y', file=s)
s.write('more')
s.seek(0)
s.write('Z')
print(repr(s.getvalue()), s.truncate(2), repr(s.getvalue()))
with io.StringIO() as s: print(s.write('abc'), s.getvalue())
try: s.read()
except ValueError as e: print(e)
b = io.BytesIO(b'abcdef')
print(b.read(2), b.tell(), b.seek(-1, 2), b.read(), b.getvalue(), b.seek(8), b.write(b'!'), b.getvalue())
print(isinstance(s, io.IOBase), isinstance(b, io.TextIOBase), issubclass(io.UnsupportedOperation, (OSError)))
class P:
    def __fspath__(self): return 'a.txt'
print(open(P()).name.__class__.__name__, open(b'x.txt').read())
try: open(1.5)
except TypeError as e: print(e)
try: open('a\0b')
except ValueError as e: print(e)
print(repr(open('x.txt')), repr(open('x.txt', 'rb')))
f = open('x.txt'); n = f.fileno()
print(n >= 3, os.fstat(n).st_size, f.isatty(), f.seekable())
import json
with open('j.json', 'w') as f: json.dump({'a': [1, 2.5, None]}, f, indent=1)
with open('j.json') as f: print(json.load(f))
