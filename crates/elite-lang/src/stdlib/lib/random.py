"""Random numbers: generators as scripts see them. Drawing, and the distributions, are native (`_random`)."""
from _random import Random as _Generator, _fresh_seed, _text_key, _spread
from _random import NV_MAGICCONST, LOG4, SG_MAGICCONST, TWOPI, BPF, RECIP_BPF

_FUNCTIONS = (
    "seed random getstate setstate getrandbits randbytes randrange randint choice choices sample shuffle uniform"
    " triangular gauss normalvariate lognormvariate expovariate vonmisesvariate gammavariate betavariate paretovariate"
    " weibullvariate"
)


class Random(_Generator):
    VERSION = 3

    def __init__(self, x=None):
        self.seed(x)

    def seed(self, a=None, version=2):
        if a is None:
            key = _fresh_seed()
        elif isinstance(a, (str, bytes, bytearray)):
            key = _text_key(a.encode() if isinstance(a, str) else bytes(a))
        elif isinstance(a, float):
            key = hash(a) % 2 ** 64
        elif isinstance(a, int):
            key = abs(a)
        else:
            raise TypeError("The only supported seed types are: None,\nint, float, str, bytes, and bytearray.")
        self._seed(key)

    @property
    def gauss_next(self):
        return self._kept()

    @gauss_next.setter
    def gauss_next(self, value):
        self._keep(value)

    def getstate(self):
        return 3, self._state(), self._kept()

    def setstate(self, state):
        version, words, kept = state
        if version != 3:
            raise ValueError(f"state with version {version} passed to Random.setstate() of version 3")
        self._set_state(words)
        self._keep(kept)


class SystemRandom(Random):
    """Numbers from the controller's own generator; a seed has no effect."""

    def seed(self, *args, **kwargs):
        super().seed(None)


_spread(Random(), _FUNCTIONS.split())
