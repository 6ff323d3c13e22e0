"""A run on disk as it happens: one MCAP message per control step, readable after a crash.

MCAP (https://mcap.dev) is append-only with checksums. The Python writer keeps a hidden buffer; ours
is handed a file that writes through, so a killed run loses one chunk at most.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self, cast

import numpy as np
from mcap.exceptions import McapError
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from swarmvision.data import Scene
from swarmvision.errors import DataError, OutputError

TOPIC = "/scene"
CHUNK_BYTES = 1 << 15
FIELDS = ("pose", "velocity", "wheel_speed", "wheel_travel", "object_pose", "object_velocity")
SCHEMA = {
    "type": "object",
    "title": "swarmvision.Scene",
    "properties": {"time": {"type": "number"}} | {name: {"type": "array"} for name in FIELDS},
}


class _WriteThrough:
    """A file that hands every byte to the system at once; no ``RawIOBase``, which the writer would buffer."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)

    def write(self, data: bytes) -> int:
        view = memoryview(data)
        while view:
            view = view[self._file.write(view) :]
        return len(data)

    def tell(self) -> int:
        return self._file.tell()

    def flush(self) -> None:
        """Nothing waits."""

    def close(self) -> None:
        self._file.close()


class Recorder:
    """Appends scenes to a recording; use as a context manager."""

    def __init__(self, path: Path) -> None:
        """Open the recording.

        Raises:
            OutputError: If the file cannot be written.
        """
        self._path = path
        try:
            self._file = _WriteThrough(path)
        except OSError as fault:
            raise OutputError(f"{path}: cannot be written: {fault.strerror or fault}") from None
        self._writer = Writer(cast("IO[bytes]", self._file), chunk_size=CHUNK_BYTES)
        self._writer.start(library="swarmvision")
        schema = self._writer.register_schema(
            name="swarmvision.Scene", encoding="jsonschema", data=json.dumps(SCHEMA).encode()
        )
        self._channel = self._writer.register_channel(schema_id=schema, topic=TOPIC, message_encoding="json")

    def write(self, scene: Scene) -> None:
        """Append a scene.

        Raises:
            OutputError: If the disk refuses it.
        """
        content = {name: getattr(scene, name).tolist() for name in FIELDS}
        stamp = round(scene.time * 1e9)
        try:
            self._writer.add_message(
                channel_id=self._channel,
                log_time=stamp,
                publish_time=stamp,
                data=json.dumps({"time": scene.time, **content}).encode(),
            )
        except OSError as fault:
            raise OutputError(f"{self._path}: cannot be written: {fault.strerror or fault}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._writer.finish()
        self._file.close()


def read(path: Path) -> list[Scene]:
    """Return the scenes of a recording; of one that was cut off, all that are whole.

    Raises:
        DataError: If the file is missing or is no recording.
    """
    scenes: list[Scene] = []
    try:
        with path.open("rb") as file:
            for record in StreamReader(file).records:
                if isinstance(record, Message):
                    scenes.append(_scene(json.loads(record.data)))
    except OSError as fault:
        raise DataError(f"{path}: cannot be read: {fault.strerror or fault}") from None
    except (McapError, EOFError, ValueError, struct.error) as fault:
        if not scenes:
            raise DataError(f"{path}: not a recording: {fault}") from None
    return scenes


def _scene(content: dict[str, Any]) -> Scene:
    columns = {"wheel_speed": 2, "wheel_travel": 2}
    arrays = {
        name: np.array(content[name], dtype=np.float64).reshape(-1, columns.get(name, 3)) for name in FIELDS
    }
    return Scene(time=float(content["time"]), **arrays)
