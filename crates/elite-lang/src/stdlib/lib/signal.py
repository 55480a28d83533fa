"""Numbers of signals. Sending and handling them needs the permission of the controller."""
import _system

SIGHUP = 1
SIGINT = 2
SIGQUIT = 3
SIGILL = 4
SIGTRAP = 5
SIGABRT = 6
SIGBUS = 7
SIGFPE = 8
SIGKILL = 9
SIGUSR1 = 10
SIGSEGV = 11
SIGUSR2 = 12
SIGPIPE = 13
SIGALRM = 14
SIGTERM = 15
SIGCHLD = 17
SIGCONT = 18
SIGSTOP = 19
SIGTSTP = 20
SIG_DFL = 0
SIG_IGN = 1
NSIG = 65


def _refused(name):
    def function(*args, **kwargs):
        _system.require("process", f"signal.{name}")
        raise NotImplementedError(f"signal.{name}: not available on this controller, even with --allow process")
    return function


signal = _refused("signal")
getsignal = _refused("getsignal")
raise_signal = _refused("raise_signal")
alarm = _refused("alarm")
setitimer = _refused("setitimer")
pause = _refused("pause")
pthread_kill = _refused("pthread_kill")
