"""Other processes. Starting them needs the permission of the controller."""
import _system

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


def _refused(name):
    def function(*args, **kwargs):
        _system.require("process", f"subprocess.{name}")
        raise NotImplementedError(f"subprocess.{name}: not available on this controller, even with --allow process")
    return function


run = _refused("run")
call = _refused("call")
check_call = _refused("check_call")
check_output = _refused("check_output")
getoutput = _refused("getoutput")
getstatusoutput = _refused("getstatusoutput")


class Popen:
    def __init__(self, *args, **kwargs):
        _refused("Popen")()
