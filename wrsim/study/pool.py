"""Worker processes of this machine without a scheduler, in the place of a client of dask: for Windows."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any, Self

from wrsim.system import BLAS_THREADS

ONE_THREAD = {name: "1" for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", *BLAS_THREADS)}
"""Environment of a worker: it computes one case at a time, on one processor."""
ATTEMPTS = 2
"""How many workers may die at the same case before it is tried alone, and again before it counts as failed."""


class WorkerDied(Exception):
    """Processes ended while they had this call."""


@dataclass(eq=False)
class Call:
    """A function for a worker, with the names of dask's `Future`; status: "pending", "finished" or "error"."""

    key: str
    function: Callable[..., object]
    arguments: tuple[Any, ...]
    status: str = "pending"
    error: Exception | None = field(default=None, repr=False)

    def exception(self) -> Exception | None:
        """What the function raised; `WorkerDied` where no process came to its end."""
        return self.error

    def release(self) -> None:
        """Nothing is stored."""


class Pool:
    """Processes that are spawned, each with a thread here that hands it calls; one that dies is started again."""

    def __init__(self, count: int) -> None:
        self._calls: SimpleQueue[Call | None] = SimpleQueue()
        self._ended: SimpleQueue[Call] = SimpleQueue()
        self._processes: list[Any] = []
        self._open = True
        self._environment = {name: os.environ.get(name) for name in ONE_THREAD}
        os.environ.update(ONE_THREAD)  # processes take it over
        self._threads = [Thread(target=self._serve_calls, daemon=True) for _ in range(count)]

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._open = False
        for _ in self._threads:
            self._calls.put(None)
        while any(thread.is_alive() for thread in self._threads):
            for process in self._processes.copy():
                process.terminate()
            for thread in self._threads:
                thread.join(0.05)
        for process in self._processes:
            process.terminate()
            process.join()
        for name, value in self._environment.items():
            os.environ.pop(name)
            os.environ.update({} if value is None else {name: value})

    def submit(self, function: Callable[..., object], *arguments: Any, key: str) -> Call:
        """Let a worker call a function of a module."""
        call = Call(key, function, arguments)
        self._calls.put(call)
        return call

    def nthreads(self) -> dict[str, int]:
        """Threads of every worker."""
        return {str(number): 1 for number in range(len(self._threads))}

    def next_ended(self) -> Call:
        """The next call that comes to its end."""
        while True:
            with suppress(Empty):
                return self._ended.get(timeout=0.5)  # Windows passes on no Ctrl-C to who waits for ever

    def _serve_calls(self) -> None:
        """What the thread of a worker does."""
        worker: tuple[Any, Any] | None = None
        while self._open and (call := self._calls.get()) is not None:
            call.error = WorkerDied(call.key)
            for _ in range(ATTEMPTS):
                process, pipe = worker = worker or self._started()
                try:
                    pipe.send((call.function, call.arguments))
                    if pipe not in wait([pipe, process.sentinel]):  # one that dies as it begins does not close its end
                        raise EOFError
                    call.error = pipe.recv()
                    break
                except (EOFError, OSError):
                    pipe.close()
                    process.join()
                    worker = None
                    if not self._open:
                        return
            call.status = "finished" if call.error is None else "error"
            self._ended.put(call)

    def _started(self) -> tuple[Any, Any]:
        context = multiprocessing.get_context("spawn")
        parent_end, child_end = context.Pipe()
        process = context.Process(target=_serve, args=(child_end,), daemon=True)
        process.start()
        child_end.close()
        self._processes.append(process)
        return process, parent_end


@dataclass
class Completed:
    """Calls of a pool in the order in which they end, as dask's ``as_completed``."""

    pool: Pool
    pending: int

    def add(self, call: object) -> None:
        """One more, submitted already."""
        self.pending += 1

    def __iter__(self) -> Iterator[Call]:
        while self.pending:
            self.pending -= 1
            yield self.pool.next_ended()


def _serve(pipe: Any) -> None:
    """What a worker does: calls, until the pool is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a console sends Ctrl-C to all of its processes
    with suppress(EOFError, OSError):
        while True:
            function, arguments = pipe.recv()
            try:
                function(*arguments)
                error = None
            except Exception as problem:
                error = problem
            pipe.send(error)
