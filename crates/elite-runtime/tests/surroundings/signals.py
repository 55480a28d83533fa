import os, signal, threading, time
seen = []
def handler(number, frame): seen.append(number)
print(signal.getsignal(signal.SIGUSR1) == signal.SIG_DFL, signal.signal(signal.SIGUSR1, handler),
      signal.getsignal(signal.SIGUSR1) is handler)
signal.raise_signal(signal.SIGUSR1)
os.kill(os.getpid(), signal.SIGUSR1)
print(seen, repr(signal.SIGUSR1), signal.SIGUSR1.name, signal.Signals(15), signal.strsignal(15))
class Late(Exception): pass
def late(number, frame): raise Late('too late')
signal.signal(signal.SIGALRM, late)
signal.alarm(1)
begin = time.monotonic()
try:
    time.sleep(30)
    print('not reached')
except Late as e: print(e, 0.9 < time.monotonic() - begin < 5)
print(signal.alarm(10) == 0, signal.alarm(0), signal.alarm(0))
signal.setitimer(signal.ITIMER_REAL, 0.1)
try:
    while True: time.sleep(0.01)
except Late as e: print(e)
signal.setitimer(signal.ITIMER_REAL, 0.1)
try: threading.Event().wait()
except Late as e: print('wait', e)
ticks = []
signal.signal(signal.SIGALRM, lambda n, f: ticks.append(n))
signal.setitimer(signal.ITIMER_REAL, 0.05, 0.05)
time.sleep(0.6)
signal.setitimer(signal.ITIMER_REAL, 0)
print(len(ticks) >= 5, signal.getitimer(signal.ITIMER_REAL))
signal.signal(signal.SIGINT, signal.default_int_handler)
try: signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt as e: print('interrupted')
signal.signal(signal.SIGUSR2, signal.SIG_IGN)
signal.raise_signal(signal.SIGUSR2)
for bad in (lambda: signal.signal(signal.SIGKILL, handler), lambda: signal.signal(99, handler),
            lambda: signal.signal(2, 5), lambda: signal.Signals(99)):
    try: bad()
    except (OSError, ValueError, TypeError) as e: print(type(e).__name__, e)
problems = []
def other():
    try: signal.signal(signal.SIGUSR1, handler)
    except ValueError as e: problems.append(str(e))
t = threading.Thread(target=other); t.start(); t.join(); print(problems)
print(signal.SIGTERM in signal.valid_signals(), int(signal.SIGINT), signal.SIG_IGN == 1, f'{signal.SIGTERM}')
