import os
here = os.getcwd()
os.mkdir('a')
os.makedirs('a/b/c')
os.makedirs('a/b/c', exist_ok=True)
for bad in (lambda: os.mkdir('a'), lambda: os.makedirs('a/b'), lambda: os.rmdir('a'), lambda: os.rmdir('zzz'),
            lambda: os.remove('zzz'), lambda: os.listdir('zzz'), lambda: os.stat('zzz'), lambda: os.rename('zzz', 'y'),
            lambda: os.chdir('zzz'), lambda: os.stat(''), lambda: os.path.getsize('zzz'), lambda: os.readlink('a'),
            lambda: os.listdir('a/b/none'), lambda: os.link('zzz', 'y')):
    try: bad()
    except OSError as e: print(type(e).__name__, e, e.filename, getattr(e, 'filename2', None))
for name in ('a/1.txt', 'a/2.txt', 'a/b/3.txt', 'a/b/c/4.txt'):
    with open(name, 'w') as f: f.write(name)
print(sorted(os.listdir('a')), sorted(os.listdir()), sorted(os.listdir(b'a')) if False else '')
print([(r, sorted(d), sorted(f)) for r, d, f in sorted(os.walk('a'))])
print([r for r, d, f in os.walk('a', topdown=False)])
print(sorted((e.name, e.path, e.is_file(), e.is_dir(), e.is_symlink(), e.stat().st_size > 0)
             for e in os.scandir('a') if e.is_file()))
with os.scandir('a') as it: print(len(list(it)))
s = os.stat('a/1.txt')
print(s.st_size, s[6], oct(s.st_mode & 0o170000), s.st_mtime > 1e9, s.st_mtime_ns // 10**9 == int(s.st_mtime), len(s))
os.chmod('a/1.txt', 0o640); print(oct(os.stat('a/1.txt').st_mode))
os.utime('a/1.txt', (1000, 2000)); print(os.path.getmtime('a/1.txt'), os.path.getatime('a/1.txt'))
os.utime('a/1.txt', ns=(1500000000, 2500000000)); print(os.stat('a/1.txt').st_mtime)
os.rename('a/1.txt', 'a/one.txt'); os.replace('a/one.txt', 'a/2.txt')
print(sorted(os.listdir('a')), open('a/2.txt').read())
os.symlink('2.txt', 'a/link'); os.link('a/2.txt', 'a/hard')
print(os.readlink('a/link'), os.path.islink('a/link'), os.path.isfile('a/link'), os.path.samefile('a/link', 'a/hard'),
      os.stat('a/hard').st_nlink)
os.symlink('nowhere', 'dead'); print(os.path.exists('dead'), os.path.lexists('dead'), os.path.islink('dead'))
os.symlink('loop', 'loop'); print(os.path.exists('loop'))
print(os.path.realpath('a/link') == here + '/a/2.txt', os.path.realpath('x/../y') == here + '/y')
print(os.path.exists('a'), os.path.isdir('a'), os.path.isfile('a'), os.path.isdir('zzz'), os.path.exists('a\0'))
print(os.path.abspath('a/../q') == here + '/q', os.path.relpath('a/b'), os.path.relpath('/x/y', '/x/z'),
      os.path.relpath('.', 'a'))
print(os.path.commonpath(['/a/b/c', '/a/b/d']), os.path.commonpath(['a/b', 'a']))
os.chdir('a/b'); print(os.getcwd() == here + '/a/b', os.path.exists('3.txt'), open('c/4.txt').read())
os.chdir('..'); print(sorted(os.listdir('.'))); os.chdir(here)
os.remove('a/hard'); os.unlink('a/link'); os.unlink('dead'); os.unlink('loop')
os.truncate('a/2.txt', 3); print(open('a/2.txt').read())
os.remove('a/2.txt'); os.remove('a/b/3.txt'); os.remove('a/b/c/4.txt')
os.removedirs('a/b/c'); print(os.listdir('.'))
print(os.access(here, os.R_OK | os.W_OK | os.X_OK), os.access('zzz', os.F_OK))
print(os.environ.get('NOT_THERE'), 'PATH' in os.environ, os.getenv('NOT_THERE', 'd'))
os.environ['OWN'] = 'v'; print(os.environ['OWN'], os.path.expandvars('$OWN/${OWN}x/$NO'), os.getenv('OWN'))
del os.environ['OWN']
for bad in (lambda: os.environ['OWN'], lambda: os.environ.__setitem__('a', 5)):
    try: bad()
    except Exception as e: print(type(e).__name__, e)
print(os.path.expanduser('~') == os.environ['HOME'], os.path.expanduser('x~'))
print(os.getpid() > 1, os.getppid() > 0, os.getuid() >= 0, os.strerror(2), os.fspath('a'), os.sep,
      os.linesep == '\n', os.name)
try: os.fspath(5)
except TypeError as e: print(e)
