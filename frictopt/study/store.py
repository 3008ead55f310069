"""Runs of a campaign on disk: one parquet part for each, named by the content of what was run."""

import os
import warnings
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import FrictoptError

__all__ = ["COLUMNS", "DamagedPart", "Store", "StoreError"]

COLUMNS = pa.schema(
    [
        ("key", pa.string()),
        ("load_factor", pa.float64()),
        ("start", pa.string()),
        ("amplitude", pa.float64()),
        ("outcome", pa.string()),
        ("dissipation", pa.float64()),
        ("first_cycle", pa.float64()),
        ("largest_share", pa.float64()),
        ("cycles", pa.int64()),
        ("slipping", pa.int64()),
        ("open", pa.int64()),
        ("residual", pa.float64()),
        ("engine", pa.string()),
        ("seconds", pa.float64()),
        ("error", pa.string()),
    ]
)
"""What a part holds of its run."""


class StoreError(FrictoptError, OSError):
    """A run cannot be written: the disk is full, or the folder is not ours to write. What was written before is kept.

    Attributes
    ----------
    table
        The runs that are finished, those on disk and those that could not be written.
    """

    table: pd.DataFrame | None = None


class DamagedPart(UserWarning):
    """A part of a store could not be read; it was set aside, and its run is repeated."""


class Store:
    """A folder of parts `KEY.parquet`, each the row of one run; `pandas.read_parquet` reads the folder as one table.

    Parameters
    ----------
    folder
        Where the parts are; made if it does not exist.

    Raises
    ------
    StoreError
        The folder cannot be made.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        try:
            self.folder = Path(folder)
            self.folder.mkdir(parents=True, exist_ok=True)
        except (OSError, TypeError, ValueError) as error:
            raise StoreError(
                f"store: {folder!r} cannot be made into a folder ({error}); give the name of a folder that exists or can be made"
            ) from error

    def path(self, key: str) -> Path:
        """File of one run."""
        return self.folder / f"{key}.parquet"

    def read(self, key: str) -> dict[str, Any] | None:
        """The row of one run; None if it is not there, or damaged: then the part is set aside, with a warning that names it."""
        path = self.path(key)
        try:
            with path.open("rb") as file:
                rows = pq.ParquetFile(file, page_checksum_verification=True).read().cast(COLUMNS).to_pylist()
            if [row["key"] for row in rows] != [key]:
                raise ValueError("it does not hold the run that it is named after")
        except FileNotFoundError:
            return None
        except (OSError, ValueError, pa.ArrowException) as error:
            aside = path.with_name(f"_damaged-{path.name}")
            path.replace(aside)
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            warnings.warn(f"store: {path.name} is damaged ({reason}); set aside as {aside.name}, its run is repeated", DamagedPart, stacklevel=3)
            return None
        row: dict[str, Any] = rows[0]
        return row

    def write(self, row: dict[str, Any]) -> None:
        """Write the row of one run, whole or not at all.

        Raises
        ------
        StoreError
            It cannot be written.
        """
        path = self.path(row["key"])
        temporary = path.with_name(f".{path.name}.{os.getpid()}")  # a leading dot: readers of the folder pass it by
        content = pa.BufferOutputStream()  # written at once: a third cheaper than by pyarrow's own files
        table = pa.Table.from_pylist([row], schema=COLUMNS)
        pq.write_table(table, content, compression="none", use_dictionary=False, write_statistics=False, write_page_checksum=True)
        try:
            temporary.write_bytes(content.getvalue())
            temporary.replace(path)
        except OSError as error:
            temporary.unlink(missing_ok=True)
            raise StoreError(f"store: {str(path)!r} cannot be written ({error}); make room and start again, finished runs are kept") from error
