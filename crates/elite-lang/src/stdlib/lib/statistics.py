"""Simple statistics."""
from math import fsum as _fsum, sqrt as _sqrt


class StatisticsError(ValueError):
    pass


def _data(data, name, least=1):
    data = list(data)
    if len(data) < least:
        if least == 1:
            raise StatisticsError(f"{name} requires at least one data point")
        raise StatisticsError(f"{name} requires at least two data points")
    return data


def _sum(data):
    return sum(data) if all(isinstance(x, int) for x in data) else _fsum(data)


def mean(data):
    data = _data(data, "mean")
    total = _sum(data)
    if isinstance(total, int) and total % len(data) == 0:
        return total // len(data)
    return total / len(data)


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


def _squares(data, centre):
    if centre is None:
        if all(isinstance(x, int) for x in data):
            n = len(data)
            return (n * sum(x * x for x in data) - sum(data) ** 2) / n
        centre = _sum(data) / len(data)
    return _fsum((x - centre) ** 2 for x in data)


def variance(data, xbar=None):
    data = _data(data, "variance", 2)
    return _squares(data, xbar) / (len(data) - 1)


def pvariance(data, mu=None):
    data = _data(data, "pvariance")
    return _squares(data, mu) / len(data)


def stdev(data, xbar=None):
    data = _data(data, "stdev", 2)
    return _sqrt(variance(data, xbar))


def pstdev(data, mu=None):
    data = _data(data, "pstdev")
    return _sqrt(pvariance(data, mu))


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
