"""Simple statistics."""
from math import fsum as _fsum, isqrt as _isqrt, lcm as _lcm, sqrt as _sqrt


class StatisticsError(ValueError):
    pass


def _kind(kind, other):
    """What numbers of two types are together: `int` gives way, otherwise the derived one stays."""
    if other is kind or other is bool or other is int:
        return kind
    if kind is int:
        return other
    if issubclass(other, kind):
        return other
    if issubclass(kind, other):
        return kind
    if issubclass(kind, int):
        return other
    if issubclass(other, int):
        return kind
    raise TypeError(f"don't know how to coerce {kind.__name__} and {other.__name__}")


def _ratio(x):
    """A number as a fraction; what is not finite has no denominator."""
    try:
        return x.as_integer_ratio()
    except AttributeError:
        pass
    except (OverflowError, ValueError):
        return x, None
    try:
        return x.numerator, x.denominator
    except AttributeError:
        raise TypeError(f"can't convert type '{type(x).__name__}' to numerator/denominator") from None


def _taken(data):
    """The items as a list, which asks for no length; where they are made one by one,
    none behind one that is no number."""
    if type(data) in (list, tuple, range):
        return list(data)
    items = []
    for x in data:
        items.append(x)
        if not isinstance(x, (int, float)):
            _ratio(x)
    return items


def _floats(data):
    """The exact sum of floats as a fraction; None if it leaves the range of floats or is not finite."""
    parts = []
    try:
        while not parts or parts[-1]:
            parts.append(_fsum([*data, *[-part for part in parts]]))
            if parts[-1] - parts[-1]:
                return None
    except (OverflowError, ValueError):
        return None
    return _joined([part.as_integer_ratio() for part in parts])


def _joined(ratios):
    """The sum of fractions as one."""
    below = _lcm(*[d for _, d in ratios])
    return sum(n * (below // d) for n, d in ratios), below


def _exact(data):
    """The type of the sum of numbers, and the sum as a fraction, exact;
    for what is not finite the denominator is None."""
    types = set(map(type, data))
    if types <= {int, bool}:
        return int, (sum(data), 1)
    found = _floats(data) if types == {float} else None
    if found is None:
        parts = {}
        for x in data:
            n, d = _ratio(x)
            parts[d] = parts.get(d, 0) + n
        found = (parts[None], None) if None in parts else _joined([(n, d) for d, n in parts.items()])
    kind = int
    for other in types:
        kind = _kind(kind, other)
    return kind, found


def _squares(data):
    """The same of the squares of the distances from the mean."""
    kind, (total, below) = _exact(data)
    if below is None:
        return kind, (total, None)
    if kind is int:
        _, (squares, square) = _exact([x * x for x in data])
    else:
        squares, square = _joined([(n * n, d * d) for n, d in map(_ratio, data)] or [(0, 1)])
    count = len(data) or 1
    return kind, _joined([(squares, square), (-total * total, below * below * count)])


def _number(kind, ratio, count):
    """A fraction divided by a count, as a number of this type."""
    n, d = ratio
    if d is None:
        value = n / count
        return value if type(value) is kind else kind(value)
    d *= count
    if not issubclass(kind, int):
        value = n / d
        return value if kind is float else kind(value)
    return n / d if n % d else kind(n // d)


def _root(ratio, count):
    """The square root of a fraction divided by a count, rounded once."""
    n, d = ratio
    if d is None:
        return _sqrt(n / count)
    d *= count
    # A root of 64 bits and more, the last of which says whether there is anything beyond it.
    shift = max(0, 130 - n.bit_length() + d.bit_length())
    shift += shift % 2
    whole = (n << shift) // d
    root = _isqrt(whole)
    root = root << 1 | (root * root * d != n << shift)
    return root / (1 << shift // 2 + 1)


def _data(data, name, least=1):
    data = list(data)
    if len(data) < least:
        if least == 1:
            raise StatisticsError(f"{name} requires at least one data point")
        raise StatisticsError(f"{name} requires at least two data points")
    return data


def mean(data):
    data = _taken(data)
    kind, total = _exact(data)
    return _number(kind, total, len(_data(data, "mean")))


def fmean(data, weights=None):
    data = _data(data, "fmean")
    if weights is None:
        return _fsum(data) / len(data)
    weights = list(weights)
    if len(weights) != len(data):
        raise StatisticsError("data and weights must be the same length")
    return _fsum(w * x for w, x in zip(weights, data)) / _fsum(weights)


def median(data):
    data = sorted(data)
    if not data:
        raise StatisticsError("no median for empty data")
    middle = len(data) // 2
    return data[middle] if len(data) % 2 else (data[middle - 1] + data[middle]) / 2


def median_low(data):
    data = sorted(data)
    if not data:
        raise StatisticsError("no median for empty data")
    return data[(len(data) - 1) // 2]


def median_high(data):
    data = sorted(data)
    if not data:
        raise StatisticsError("no median for empty data")
    return data[len(data) // 2]


def multimode(data):
    counts = {}
    for item in data:
        counts[item] = counts.get(item, 0) + 1
    most = max(counts.values(), default=0)
    return [item for item, count in counts.items() if count == most]


def mode(data):
    modes = multimode(data)
    if not modes:
        raise StatisticsError("no mode for empty data")
    return modes[0]


def _spread(data, centre, name, least):
    if centre is None:
        data = _taken(data)
        kind, squares = _squares(data)
    else:
        data = [(x - centre) * (x - centre) for x in data]
        kind, squares = _exact(data)
    return kind, squares, len(_data(data, name, least)) - least + 1


def variance(data, xbar=None):
    return _number(*_spread(data, xbar, "variance", 2))


def pvariance(data, mu=None):
    return _number(*_spread(data, mu, "pvariance", 1))


def stdev(data, xbar=None):
    return _root(*_spread(data, xbar, "stdev", 2)[1:])


def pstdev(data, mu=None):
    return _root(*_spread(data, mu, "pstdev", 1)[1:])


def geometric_mean(data):
    from math import exp, log
    data = list(data)
    if not data:
        raise StatisticsError("geometric mean requires a non-empty dataset containing positive numbers")
    try:
        return exp(fmean([log(x) for x in data]))
    except ValueError:
        raise StatisticsError("geometric mean requires a non-empty dataset containing positive numbers") from None


def harmonic_mean(data, weights=None):
    data = list(data)
    if not data:
        raise StatisticsError("harmonic_mean requires at least one data point")
    given = weights
    weights = [1] * len(data) if weights is None else list(weights)
    if len(weights) != len(data):
        raise StatisticsError("Number of weights does not match data size")
    if any(x < 0 for x in data):
        raise StatisticsError("harmonic mean does not support negative values")
    if 0 in data:
        return 0
    if len(data) == 1 and given is None:
        return data[0]
    # The quotients are rounded, their sum is exact: in units of the smallest float.
    unit, total = 2 ** 1074, 0
    for w, x in zip(weights, data):
        top, below = (w / x).as_integer_ratio() if w else (0, 1)
        total += top * (unit // below)
    top, below = _fsum(weights).as_integer_ratio()
    return top * unit / (below * total)


def quantiles(data, *, n=4, method="exclusive"):
    if n < 1:
        raise StatisticsError("n must be at least 1")
    data = sorted(data)
    count = len(data)
    if count < 2:
        raise StatisticsError("must have at least two data points")
    result = []
    if method == "inclusive":
        for i in range(1, n):
            j, delta = divmod(i * (count - 1), n)
            result.append((data[j] * (n - delta) + data[j + 1] * delta) / n)
        return result
    if method == "exclusive":
        for i in range(1, n):
            j = min(max(i * (count + 1) // n, 1), count - 1)
            delta = i * (count + 1) - j * n
            result.append((data[j - 1] * (n - delta) + data[j] * delta) / n)
        return result
    raise ValueError(f"Unknown method: {method!r}")


def _pairs(x, y, name):
    if len(x) != len(y):
        raise StatisticsError(f"{name} requires that both inputs have same number of data points")
    if len(x) < 2:
        raise StatisticsError(f"{name} requires at least two data points")
    return fmean(x), fmean(y)


def covariance(x, y, /):
    xbar, ybar = _pairs(x, y, "covariance")
    return _fsum((xi - xbar) * (yi - ybar) for xi, yi in zip(x, y)) / (len(x) - 1)


def correlation(x, y, /):
    xbar, ybar = _pairs(x, y, "correlation")
    sxy = _fsum((xi - xbar) * (yi - ybar) for xi, yi in zip(x, y))
    sxx = _fsum((xi - xbar) ** 2.0 for xi in x)
    syy = _fsum((yi - ybar) ** 2.0 for yi in y)
    try:
        return sxy / _sqrt(sxx * syy)
    except ZeroDivisionError:
        raise StatisticsError("at least one of the inputs is constant") from None


def _linear_regression(x, y, proportional):
    if len(x) != len(y):
        raise StatisticsError("linear regression requires that both inputs have same number of data points")
    if len(x) < 2:
        raise StatisticsError("linear regression requires at least two data points")
    xbar, ybar = (0, 0) if proportional else (fmean(x), fmean(y))
    sxx = _fsum((xi - xbar) * (xi - xbar) for xi in x)
    if sxx == 0:
        raise StatisticsError("x is constant")
    slope = _fsum((xi - xbar) * (yi - ybar) for xi, yi in zip(x, y)) / sxx
    return slope, 0.0 if proportional else ybar - slope * xbar


def linear_regression(x, y, /, *, proportional=False):
    from _collections import namedtuple
    return namedtuple("LinearRegression", ("slope", "intercept"))(*_linear_regression(x, y, proportional))
