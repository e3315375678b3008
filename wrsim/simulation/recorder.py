"""Where the samples of a run go: into memory, or into a file from which a run that died goes on.

The integrator hands over one row per sample. A ``FileRecorder`` writes them out whenever its block is full or
``FLUSH_INTERVAL`` has passed, together with a checkpoint: step number, state, and what the force law and the monitor
remember. Checkpoints lie between the segments of a run (``integrate``): a process that dies loses that much wall time
and one segment, and the memory that sampling needs does not grow with the run. What a run remembers when it stops
within a segment is kept as well, to be read; it goes on from the checkpoint before.

A run that goes on from a checkpoint computes the same numbers, to the bit, as one that was never interrupted: the
integrator's times are whole multiples of its step, it begins every segment anew (``System.solve``), its state is
complete, and whatever survives a call of the law or the monitor is kept if they have ``memory()`` and ``recall()``
(``Remembers``).
"""

from __future__ import annotations

import struct
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, get_args, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.results.files import plain_disk_errors
from wrsim.results.room import below_each_other
from wrsim.results.run_file import Record, RunFile, opened_run_file

Array = NDArray[np.float64]
Cause = Literal["", "monitor", "interrupt", "not-finite", "forces", "cut-off"]

FLUSH_INTERVAL = 0.5
"""Longest wall time between two flushes [s]."""

BLOCK = 256
"""Samples that wait in memory for the next flush, at most."""

_FLUSH, _STOP, _END = b"FLSH", b"STOP", b"END."
_COUNTS = struct.Struct("<qqq")  # step of the checkpoint (-1: there is none), rows, length of the memory


@runtime_checkable
class Remembers(Protocol):
    """A force law or a monitor whose next answer depends on more than time and state."""

    def memory(self) -> Array:
        """A copy of everything that it keeps from one call to the next, in one row."""

    def recall(self, memory: Array) -> None:
        """Put it back."""


def memory_of(things: Sequence[object]) -> Array:
    """What those that remember keep, one after the other, each behind its length."""
    rows = [thing.memory() if isinstance(thing, Remembers) else np.zeros(0) for thing in things]
    return np.concatenate([part for row in rows for part in ([float(len(row))], row)])


def recall(things: Sequence[object], memory: Array, name: str = "") -> None:
    """The opposite of ``memory_of`` for the same things; name: of the file that it comes from, if any.

    Raises ``InputError`` for what these things cannot have remembered.
    """
    place = 0
    try:
        for thing in things:
            n = int(memory[place])
            if isinstance(thing, Remembers):
                thing.recall(memory[place + 1 : place + 1 + n])
            place += 1 + n
    except (ValueError, IndexError, OverflowError):  # other lengths, and counts that are none
        why = "what it remembers does not fit its scenario; run the scenario again"
        raise InputError(f"{name or 'the checkpoint of the run'}: {why}") from None


@dataclass(frozen=True)
class Checkpoint:
    """All that a run needs to go on behind step ``step``: coordinates, rates, and memory (``memory_of``)."""

    step: int
    q: Array
    q_t: Array
    memory: Array


@dataclass(frozen=True)
class Ending:
    """How a run ended: ``cause`` is empty when it reached its end."""

    cause: Cause
    reason: str


class Recorder:
    """Samples in memory. Rows are (time, q, q_t)."""

    checkpoint: Checkpoint | None = None
    """Where to go on; None at the beginning of a run."""

    last: Checkpoint | None = None
    """What was remembered last, where the run goes on or not."""

    ending: Ending | None = None
    """Of a run that is over already."""

    name = ""
    """Of the file that holds it, if any."""

    def __init__(self, size: int) -> None:
        """size: number of coordinates."""
        self.size = size
        self._block = np.zeros((BLOCK, 1 + 2 * size))
        self._used = 0
        self._kept: list[Array] = []

    def sample(self, t: float, q: Array, q_t: Array) -> None:
        """Keep one row."""
        if self._used == BLOCK:
            self.flush(None)
        row = self._block[self._used]
        row[0] = t
        row[1 : 1 + self.size] = q
        row[1 + self.size :] = q_t
        self._used += 1

    def due(self) -> bool:
        """True when the integrator should give a checkpoint to ``flush``."""
        return False

    def flush(self, checkpoint: Checkpoint | None, goes_on: bool = True) -> None:
        """Put the waiting rows away; checkpoint: of the last step, if it is known; goes_on: whether a run may go on
        from it."""
        if self._used:
            self._kept.append(self._block[: self._used].copy())
        self._used = 0

    def end(self, ending: Ending) -> None:
        """The run is over."""
        self.flush(None)

    def rows(self) -> Array:
        """All samples (n, 1 + 2 size)."""
        self.flush(None)
        return np.concatenate(self._kept) if self._kept else np.zeros((0, 1 + 2 * self.size))


class FileRecorder(Recorder):
    """Samples and checkpoints in a file; see the module."""

    def __init__(self, file: RunFile, size: int) -> None:
        super().__init__(size)
        self._file, self.name = file, str(file.path)
        self._flushed = time.perf_counter()

    @classmethod
    def create(cls, path: str | Path, header: dict[str, Any], size: int) -> FileRecorder:
        """Start the file of a new run; header: what the reader needs to know of it."""
        return cls(RunFile.create(path, header | {"size": size}), size)

    @classmethod
    def continued(cls, path: str | Path) -> FileRecorder:
        """Go on with a file: from its last checkpoint, or with nothing but its ``ending`` to tell.

        A run that the user has interrupted goes on. Raises ``InputError`` when there is nothing to go on from.
        """
        with opened_run_file(path):  # a file that is not there, or none of a run's, is told as for reading
            pass
        file = RunFile.opened(path)
        try:  # read while nobody else can write
            recorded = Recording.of(Path(path), *file.read())
            over = recorded.ending is not None and recorded.ending.cause != "interrupt"
            if recorded.checkpoint is None:
                raise InputError(f"{path}: the run was cut off before its start; run the scenario again")
            file.cut(recorded.end if over else recorded.checkpoint_end)
        except BaseException:
            file.close()
            raise
        recorder = cls(file, recorded.size)
        recorder.checkpoint, recorder.last = recorded.checkpoint, recorded.last
        recorder.ending = recorded.ending if over else None
        return recorder

    def due(self) -> bool:
        """See ``Recorder``."""
        return self._used == BLOCK or time.perf_counter() - self._flushed >= FLUSH_INTERVAL

    def flush(self, checkpoint: Checkpoint | None, goes_on: bool = True) -> None:
        """Write the waiting rows and the checkpoint as one record."""
        rows = self._block[: self._used].tobytes()
        if checkpoint is None:
            if self._used:
                self._file.append(_FLUSH, _COUNTS.pack(-1, self._used, 0), rows)
        else:
            counts = _COUNTS.pack(checkpoint.step, self._used, len(checkpoint.memory))
            state = (checkpoint.q, checkpoint.q_t, checkpoint.memory)
            kind = _FLUSH if goes_on else _STOP
            self._file.append(kind, counts, rows, *(np.asarray(a, dtype=float).tobytes() for a in state))
        self._used = 0
        self._flushed = time.perf_counter()

    def end(self, ending: Ending) -> None:
        """See ``Recorder``."""
        self.flush(None)
        self._file.append(_END, ending.cause.encode() + b"\0" + ending.reason.encode())

    def rows(self) -> Array:
        """See ``Recorder``."""
        self.flush(None)
        return Recording.of(self._file.path, *self._file.read()).rows

    def close(self) -> None:
        """Close the file; it stays."""
        self._file.close()


@dataclass(frozen=True)
class Recording:
    """What a run file holds.

    rows (n, 1 + 2 size): samples; checkpoint: the last one from which the run may go on, its record ends at
    ``checkpoint_end``; last: the last one; ending: None when the process died first; end: of the last whole record.
    """

    header: dict[str, Any]
    size: int
    rows: Array
    checkpoint: Checkpoint | None
    checkpoint_end: int
    last: Checkpoint | None
    ending: Ending | None
    end: int

    @classmethod
    def read(cls, path: str | Path) -> Recording:
        """Read a file as far as it is whole. Raises ``InputError`` when there is no such file, or none of a run."""
        with opened_run_file(path) as (header, records):
            return cls.of(Path(path), header, records)

    @classmethod
    def of(cls, path: Path, header: dict[str, Any], records: Iterable[Record]) -> Recording:
        """From the header and the records of a file."""
        size = header["size"]
        width = 1 + 2 * size
        checkpoint: Checkpoint | None = None
        last: Checkpoint | None = None
        ending: Ending | None = None
        checkpoint_end, end = 0, 0

        def blocks() -> Iterator[Array]:
            nonlocal checkpoint, checkpoint_end, last, ending, end
            time = -np.inf
            for record in records:
                end = record.end
                if record.kind == _END:
                    cause, _, reason = record.content.decode(errors="replace").partition("\0")
                    if cause not in get_args(Cause):
                        raise InputError(
                            f"{path}: ends with {cause!r:.40}; must be one of {', '.join(get_args(Cause)[1:])}"
                        )
                    ending = Ending(cause, reason)  # type: ignore[arg-type]
                    continue
                step, count, memory = _counts(path, record, size)
                values = np.frombuffer(record.content, dtype="<f8", offset=_COUNTS.size)
                samples = values[: count * width].reshape(count, width).copy()  # without its checkpoint
                times = np.append(time, samples[:, 0])
                state = values[count * width : len(values) - memory]
                if not (np.isfinite(samples).all() and np.isfinite(state).all() and (np.diff(times) > 0.0).all()):
                    raise InputError(
                        f"{path}: holds samples that are not finite or do not follow each other in time; "
                        "run the scenario again"
                    )
                time = times[-1]
                yield samples
                if step >= 0:
                    q, q_t, kept = np.split(values[count * width :], [size, 2 * size])
                    last = Checkpoint(step, q.copy(), q_t.copy(), kept.copy())
                    if record.kind == _FLUSH:
                        checkpoint, checkpoint_end = last, end

        with plain_disk_errors(path):
            rows = below_each_other(blocks(), width, path.parent)
        return cls(header, size, rows, checkpoint, checkpoint_end, last, ending, end)


def _counts(path: Path, record: Record, size: int) -> tuple[int, int, int]:
    """Step, rows and length of the memory of a record, which go with the length that it has."""
    if record.kind in (_FLUSH, _STOP) and len(record.content) >= _COUNTS.size:
        step, count, memory = _COUNTS.unpack_from(record.content)
        state = 2 * size + memory if step >= 0 else 0
        numbers = count * (1 + 2 * size) + state
        if count >= 0 and memory >= 0 and len(record.content) == _COUNTS.size + 8 * numbers and step < 2**53:
            return step, count, memory
        raise InputError(
            f"{path}: a record of {len(record.content)} bytes says that it holds {count} samples and {memory} numbers "
            "beside them; run the scenario again"
        )
    raise InputError(f"{path}: holds a record that no run writes ({record.kind!r:.20}); run the scenario again")
