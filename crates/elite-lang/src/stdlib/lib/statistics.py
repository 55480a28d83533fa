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
