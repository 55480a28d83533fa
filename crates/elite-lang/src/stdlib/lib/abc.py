"""Marks for abstract methods. There are no metaclasses here, so making an instance is not refused."""


def abstractmethod(funcobj):
    funcobj.__isabstractmethod__ = True
    return funcobj


class ABC:
    pass
