"""Scheduler and workers of dask without their web pages, which show a study to whoever asks."""

from __future__ import annotations

from typing import Any

from distributed import Scheduler, Worker


class _WithoutPages:
    """Goes with ``dashboard=False``, else dask adds pages to a server that is not there."""

    def start_http_server(self, *arguments: Any, **options: Any) -> None:
        """Nothing listens."""


class QuietScheduler(_WithoutPages, Scheduler):
    """A scheduler that only answers who has its credentials."""


class QuietWorker(_WithoutPages, Worker):
    """A worker that only answers who has its credentials."""
