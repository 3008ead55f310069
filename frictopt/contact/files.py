"""Files that are to be written, checked before anything is computed."""

from pathlib import Path

from ..errors import ModelError

WRITERS = {".csv": "to_csv", ".xlsx": "to_excel", ".parquet": "to_parquet"}
"""Ending of the file of a table -> the method of pandas that writes it."""


def output(name: str | Path, *endings: str) -> Path:
    """A file to be written, in a folder that exists, with one of these endings (of none: any).

    Raises
    ------
    ModelError
        Another ending, no such folder.
    """
    file = Path(name)
    if endings and file.suffix not in endings:
        raise ModelError(f"{str(name)!r}; give a file that ends in {', '.join(endings)}")
    if not file.absolute().parent.is_dir():
        raise ModelError(f"{str(name)!r} is in no folder that exists; make it")
    return file
