"""Values as strict JSON: a number that is not known (nan) is null, an infinite one is a text."""

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

from .checks import is_distribution


def strict_json(value: object) -> str:
    """A value as strict JSON, see `plain`."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def plain(value: Any) -> Any:
    """A value in the types of JSON: nan is None, infinity is "inf", a table is a list of its rows.

    Names of Enum members are texts. A dataclass has its public fields by name.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        if math.isnan(value):
            return None
        return float(value) if math.isfinite(value) else f"{value}"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, tuple | list | range):
        return [plain(part) for part in value]
    return _plain_of_object(value)


def _plain_of_object(value: Any) -> Any:
    """A dataclass, or a value of numpy or pandas, in the types of JSON."""
    if is_dataclass(value):
        names = [field.name for field in fields(value) if not field.name.startswith("_")]
        return {name: plain(getattr(value, name)) for name in names}
    if hasattr(value, "to_dict") and hasattr(value, "columns"):
        return [plain(row) for row in value.to_dict("records")]
    if is_distribution(value):
        return {"distribution": value.dist.name, "parameters": plain(value.args), **value.kwds}
    if hasattr(value, "tolist"):  # an array, or a number of numpy
        return plain(value.tolist())
    import pandas as pd

    return None if value is pd.NA else str(value)
