"""Sweeps: on this machine, or on a Ray cluster."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from concurrent.futures import TimeoutError as ResultTimeout
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from greenstick import _native
from greenstick.errors import InputError, SweepError

# Times that a part is begun again after its process was killed.
_RETRIES = 3
# Tasks of a Ray cluster for each of its cores: so that none waits long for the last ones.
_PARTS_PER_CORE = 4
# Seconds until a cluster must have answered.
_ANSWER = 30.0


@dataclass(frozen=True)
class Sweep:
    """What came of a sweep.

    Attributes
    ----------
    folder
        Folder of the pieces, the table, the contact sheet and the journal.
    report
        ``variants`` asked for, those ``found`` that an earlier run made, ``made`` by this one, ``failed`` of all, and the paths
        ``table`` and ``sheet``; both are None of a part.
    """

    folder: Path
    report: dict[str, Any]

    def table(self) -> Any:
        """One row for each variant, as a ``pyarrow.Table``: what varied, the figures of its report with their units, its file, the
        seconds that it took, and its error."""
        try:
            import pyarrow.parquet
        except ImportError as error:
            raise ImportError("tables need pyarrow: pip install pyarrow") from error
        if self.report["table"] is None:
            raise InputError("a part has no table; the sweep without `part` takes over what parts have made and writes it")
        return pyarrow.parquet.read_table(self.report["table"])

    def __len__(self) -> int:
        return int(self.report["variants"])


def sweep(
    description: Mapping[str, Any] | str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    part: str | None = None,
    threads: int | None = None,
    many: bool = False,
    progress: bool | Callable[[str, float], object] | None = None,
    engine: Literal["local", "ray"] = "local",
    address: str | None = None,
    parts: int | None = None,
) -> Sweep:
    """Makes many breaks, simulations or bending tests with parameters that vary.

    What an earlier call made in the folder is kept: a sweep that was stopped or killed goes on with what is missing. A variant
    that cannot be made is a row with its error.

    Parameters
    ----------
    description
        A file (.toml), or what is in one as a dictionary:
        ``{"species": "white oak", "sweep": {"samples": 10}, "vary": {"high.height": {"between": [0.5, 2]}}}``.
    output
        Folder for the pieces, the table, the contact sheet and the journal.
    part
        Which part of the variants is made, such as "2/4"; no table is written then.
    threads
        Threads; all cores without it. With ``engine="ray"`` those of each task, 1 without it.
    many
        Whether more than 10,000 variants are meant.
    progress
        True for a bar of tqdm, or a function of the stage and the fraction of the whole.
    engine
        "local", or "ray": the parts of the sweep are tasks of a Ray cluster. All its machines must see the folder, and the files
        that the sweep names, at the same paths.
    address
        Address of the cluster; without it the one that this process has joined, or else a local one.
    parts
        Tasks for the cluster; four for each of its cores without it.

    Raises
    ------
    ParameterError
        Where the description is wrong.
    SweepError
        Where the folder holds another sweep, another process is at work there, or a task failed again and again.
    """
    text, folder = _read(description)
    output = Path(output)
    if engine == "local":
        if address is not None or parts is not None:
            raise InputError('address and parts are those of a cluster; expected engine="ray" with them')
        return Sweep(output, _native._sweep(text, folder, output, part, threads, many, progress))
    if engine != "ray":
        raise InputError(f'engine is {engine!r}; expected "local" or "ray"')
    if part is not None:
        raise InputError('engine="ray" makes all parts; expected no part with it')
    count = _native._sweep_count(text, folder)
    if count > _native._MANY_VARIANTS and not many:
        raise InputError(f"the sweep has {count} variants, which may be a mistake; many=True makes them")
    _on_ray(text, folder, output.absolute(), count, address, parts, threads or 1, progress)
    # Takes over what the parts have made, and makes what they left.
    return Sweep(output, _native._sweep(text, folder, output, None, None, True, None))


def _read(description: Mapping[str, Any] | str | os.PathLike[str]) -> tuple[str, Path]:
    """The text of a sweep, and the folder that its relative files begin in."""
    if isinstance(description, Mapping):
        return _native._sweep_text(json.dumps(_nested(description))), Path.cwd()
    path = Path(description)
    return path.read_text(encoding="utf-8"), path.absolute().parent


def _nested(description: Mapping[str, Any]) -> dict[str, Any]:
    """Keys with dots, "high.height", as the tables that they stand for."""
    nested: dict[str, Any] = {}
    for key, value in description.items():
        if isinstance(value, Mapping):
            value = _nested(value)
        *tables, last = key.split(".")
        table = nested
        for name in tables:
            table = table.setdefault(name, {})
        if isinstance(value, dict) and isinstance(table.get(last), dict):
            table[last].update(value)
        else:
            table[last] = value
    return nested


def _make_part(text: str, folder: str, output: str, part: str, threads: int) -> dict[str, Any]:
    """A task of a cluster: what is missing of a part. One that was killed goes on from its journal."""
    return _native._sweep(text, Path(folder), Path(output), part, threads, True, None)


def _on_ray(
    text: str,
    folder: Path,
    output: Path,
    count: int,
    address: str | None,
    parts: int | None,
    threads: int,
    progress: bool | Callable[[str, float], object] | None,
) -> None:
    """Makes all parts of a sweep as tasks of a Ray cluster."""
    ray = _ray()
    started = not ray.is_initialized()
    if started:
        _join(ray, address)
    try:
        cores = int(ray.cluster_resources().get("CPU", 1))
        parts = max(1, min(count, parts or _PARTS_PER_CORE * cores))
        # Ray begins a task again whose process or machine is gone; other errors are the sweep's own and end it.
        task = ray.remote(num_cpus=threads, max_retries=_RETRIES)(_make_part)
        waiting = {
            task.remote(text, str(folder), str(output), f"{number}/{parts}", threads): number
            for number in range(1, parts + 1)
        }
        shown = _native._Shown(progress)
        try:
            while waiting:
                ready, _ = ray.wait(list(waiting), num_returns=1, timeout=0.2)
                for done in ready:
                    _result(ray, done, f"{waiting.pop(done)}/{parts}")
                shown.show("variants", 1.0 - len(waiting) / parts)
        except BaseException:
            for left in waiting:
                ray.cancel(left, force=True)
            raise
        finally:
            shown.close()
    finally:
        if started:
            ray.shutdown()


def _ray() -> Any:
    try:
        import ray
    except ImportError as error:
        raise ImportError('engine="ray" needs Ray: pip install ray') from error
    return ray


def _join(ray: Any, address: str | None) -> None:
    if address is None:
        ray.init(include_dashboard=False, log_to_driver=False)
        return
    # Ray itself waits for minutes for an address where nothing is.
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if host and port.isdigit():
        import socket

        try:
            socket.create_connection((host, int(port)), timeout=_ANSWER).close()
        except OSError as error:
            raise SweepError(f"the Ray cluster at {address} does not answer: {error}", "work") from error
    try:
        ray.init(address=address, log_to_driver=False)
    except (ConnectionError, RuntimeError, ValueError, ResultTimeout) as error:
        raise SweepError(f"the Ray cluster at {address} does not answer: {error}", "work") from error


def _result(ray: Any, done: Any, part: str) -> None:
    """Raises what a task failed with."""
    try:
        ray.get(done)
    except ray.exceptions.RayTaskError as error:
        raise error.cause from None
    except ray.exceptions.RayError as error:
        raise SweepError(
            f"the process that makes part {part} died {_RETRIES + 1} times: {error}; what it has made is kept, and the journal of "
            "that part ends before the variant that it dies of",
            "work",
        ) from error
