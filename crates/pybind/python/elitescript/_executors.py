"""Who runs the units of a sweep: threads, processes, Ray or Dask. Each that fails is repeated once.

The executors are those of ``concurrent.futures``, Ray and Dask; here is only what a sweep asks of all of them.
"""

from __future__ import annotations

import concurrent.futures as futures
import importlib
import logging
import os
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

from ._units import Live, Row, Unit, gave_up, run_unit, worker_died

#: Units that wait at each worker, so that none is idle and an endless iterator is not read ahead.
_AHEAD = 2
#: A wait is begun again so often, s: an interrupt that comes while Python is about to wait does not wake it.
_LOOK_EVERY = 0.2


def _awaited(future: "futures.Future[Row]") -> Row:
    while not futures.wait([future], _LOOK_EVERY).done:
        pass
    return future.result()


class _Pool:
    """Runs units on workers of some kind; each that fails is repeated once."""

    def __init__(self, workers: Optional[int]) -> None:
        self.workers = workers or os.cpu_count() or 1

    def __enter__(self) -> "_Pool":
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        pass

    def submit(self, unit: Unit) -> "futures.Future[Row]":
        raise NotImplementedError

    def again(self, units: List[Unit], error: BaseException) -> Iterator[Tuple[Unit, Row]]:
        """Repeats units that have failed, one after the other, so that each answers for itself."""
        for unit in units:
            try:
                row = _awaited(self.submit(unit))
            except Exception as second:
                row = gave_up(unit, second)
            yield unit, row

    def rows(self, units: Iterator[Unit]) -> Iterator[Tuple[Unit, Row]]:
        waiting: Dict["futures.Future[Row]", Unit] = {}
        more = True
        while more or waiting:
            while more and len(waiting) < self.workers * _AHEAD:
                unit = next(units, None)
                if unit is None:
                    more = False
                    break
                try:
                    waiting[self.submit(unit)] = unit
                except futures.BrokenExecutor as refused:
                    broken: "futures.Future[Row]" = futures.Future()
                    broken.set_exception(refused)
                    waiting[broken] = unit
                    break
            if not waiting:
                continue
            done, _ = futures.wait(waiting, _LOOK_EVERY, futures.FIRST_COMPLETED)
            failed: List[Unit] = []
            trouble: Optional[BaseException] = None
            for future in done:
                unit = waiting.pop(future)
                error = future.exception()
                if error is None:
                    yield unit, future.result()
                else:
                    failed.append(unit)
                    trouble = error
            if trouble is not None:
                if worker_died(trouble):
                    # What waited at the pool may be gone with it, or take others along:
                    # repeats are made when all is quiet.
                    for future, unit in list(waiting.items()):
                        while not futures.wait([future], _LOOK_EVERY).done:
                            pass
                        if future.exception() is None:
                            yield unit, future.result()
                        else:
                            failed.append(unit)
                    waiting.clear()
                failed.sort(key=lambda unit: unit["index"])
                yield from self.again(failed, trouble)


class _Threads(_Pool):
    def __enter__(self) -> "_Threads":
        self._pool = futures.ThreadPoolExecutor(self.workers, "sweep")
        self._live = Live()
        return self

    def submit(self, unit: Unit) -> "futures.Future[Row]":
        return self._pool.submit(run_unit, unit, self._live)

    def __exit__(self, kind: Any, *_: Any) -> None:
        if kind is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            self._live.stop_all()
        self._pool.shutdown()


class _Processes(_Pool):
    _pool: Optional[futures.ProcessPoolExecutor] = None

    def _made(self, workers: int) -> futures.ProcessPoolExecutor:
        import multiprocessing

        # A forked child would have none of this process's threads.
        return futures.ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"))

    def submit(self, unit: Unit) -> "futures.Future[Row]":
        if self._pool is None:
            self._pool = self._made(self.workers)
        return self._pool.submit(run_unit, unit)

    def again(self, units: List[Unit], error: BaseException) -> Iterator[Tuple[Unit, Row]]:
        if not isinstance(error, futures.BrokenExecutor):
            yield from super().again(units, error)
            return
        if self._pool is not None:
            self._pool.shutdown(wait=False)
            self._pool = None
        for unit in units:
            # A worker of its own: whoever kills it takes nobody else along.
            with self._made(1) as alone:
                try:
                    row = _awaited(alone.submit(run_unit, unit))
                except Exception as second:
                    row = gave_up(unit, second)
            yield unit, row

    def __exit__(self, kind: Any, *_: Any) -> None:
        if self._pool is None:
            return
        if kind is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
        self._pool.shutdown(cancel_futures=kind is not None)


class _Ray(_Pool):
    """Ray as it runs, or a local cluster for this sweep."""

    def __enter__(self) -> "_Ray":
        try:
            ray = importlib.import_module("ray")
        except ImportError:
            raise ImportError('this executor needs Ray: pip install "elitescript[ray]"') from None
        self._began = not ray.is_initialized()
        if self._began:
            ray.init(num_cpus=self.workers, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
        else:
            self.workers = max(1, int(ray.cluster_resources().get("CPU", 1)))
        self._ray = ray
        # Repeats are counted here.
        self._run = ray.remote(max_retries=0)(run_unit)
        return self

    def submit(self, unit: Unit) -> "futures.Future[Row]":
        future: "futures.Future[Row]" = self._run.remote(unit).future()
        return future

    def __exit__(self, kind: Any, *_: Any) -> None:
        if self._began:
            self._ray.shutdown()


class _Dask(_Pool):
    """The cluster of the current ``distributed.Client``, or a local one for this sweep."""

    def __enter__(self) -> "_Dask":
        try:
            distributed = importlib.import_module("distributed")
            dask = importlib.import_module("dask")
        except ImportError:
            raise ImportError('this executor needs Dask: pip install "elitescript[dask]"') from None
        self._began: List[Any] = []
        try:
            self._client = distributed.Client.current()
        except ValueError:
            # Repeats are counted here, so a worker that dies takes its unit along at once.
            with dask.config.set({"distributed.scheduler.allowed-failures": 0}):
                cluster = distributed.LocalCluster(
                    n_workers=self.workers, threads_per_worker=1, dashboard_address=None, silence_logs=logging.CRITICAL
                )
            self._client = distributed.Client(cluster, set_as_default=False)
            self._began = [self._client, cluster]
        else:
            self.workers = max(1, sum(self._client.nthreads().values()))
        self._pool = self._client.get_executor(pure=False, retries=0)
        return self

    def submit(self, unit: Unit) -> "futures.Future[Row]":
        future: "futures.Future[Row]" = self._pool.submit(run_unit, unit)
        return future

    def __exit__(self, kind: Any, *_: Any) -> None:
        self._pool.shutdown(wait=kind is None)
        for own in self._began:
            own.close()


EXECUTORS: Dict[str, Callable[[Optional[int]], Any]] = {
    "threads": _Threads,
    "processes": _Processes,
    "ray": _Ray,
    "dask": _Dask,
}
