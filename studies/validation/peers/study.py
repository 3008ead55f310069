"""The same contacts by other codes and by frictopt: errors against closed forms, and times.

Run with `python -m studies peers [--quick] [--pythons PYTHON ...]`; it prints two tables in
Markdown. tamaas, Kratos, Siconos and GetFEM run in other Python interpreters, which `--pythons`
names. The default is the Python of the study and the Python of the system. If no Python imports a
peer, the table names the command that installs it. Times are processor times.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from studies.origin import machine
from studies.progress import each
from studies.tables import Study, Table, markdown, two_digits
from studies.validation.error_vs_time.methods import EPSILON
from studies.validation.peers import plane, printed, spheres
from studies.validation.peers.parameters import FULL, QUICK, Parameters
from studies.validation.peers.programs import PEERS, Pythons
from studies.validation.peers.questions import OURS, Contact, answered


def contacts(parameters: Parameters) -> Iterator[Contact]:
    """The contacts of all files."""
    yield from plane.contacts(parameters)
    yield from spheres.contacts(parameters)
    yield from printed.contacts(parameters)


def compared(parameters: Parameters, pythons: list[str] | None = None) -> pd.DataFrame:
    """One row for each contact and way to compute it; versions of the peers in `attrs`."""
    known = Pythons(tuple(pythons)) if pythons else Pythons()
    rows = []
    with threadpool_limits(1):
        for contact in each(contacts(parameters), "contacts"):
            rows += answered(contact, known, parameters.repetitions, parameters.seconds)
    table = pd.DataFrame(rows)
    versions = {peer.name: known.version(peer) or "not installed" for peer in PEERS}
    table.attrs = {"machine": f"{machine()}, one thread used", "peers": versions}
    return table


def report(tables: Mapping[str, pd.DataFrame]) -> str:
    """Versions, and a table of the contacts."""
    table = tables[PEERS_TABLE.name]
    versions = ", ".join(f"{name} {number}" for name, number in table.attrs["peers"].items())
    rows = []
    for (name, quantity, reference), part in table.groupby(
        ["contact", "quantity", "reference"], sort=False
    ):
        about = f"{name}: {quantity} ({reference})"
        for row in _shown(part):
            rows.append([about, _name(row), row.setting, *_cost(row), _beside(row)])
            about = ""
    head = ["contact: quantity (reference)", "code", "setting", "error", "ms", "time / ours"]
    versions = f"{table.attrs['machine']}; {versions}."
    return f"\n{versions}\n\n{markdown(head, rows)}"


def _shown(part: pd.DataFrame) -> Iterator[Any]:
    """The rows of the printed table.

    If a method fails in several rows for the same reason, they become one row.
    """
    seen = set()
    for row in part.itertuples():
        failed = (row.code, row.method, row.result)
        if row.result != "answer" and failed in seen:
            continue
        seen.add(failed)
        yield row


def _name(row: Any) -> str:
    """Code and method of a row."""
    code = row.code if row.code != OURS else f"**{OURS}**"
    return f"{code}, {row.method}" if row.method and row.method != row.code else code


def _cost(row: Any) -> tuple[str, str]:
    """Error and time of a row."""
    if row.result != "answer":
        return row.result, ""
    error = "rounding" if row.error <= 100 * EPSILON else f"{row.error:.1e}"
    return error, two_digits(1e3 * row.seconds)


def _beside(row: Any) -> str:
    """Time divided by the time of the fastest answer of frictopt that is as exact."""
    if row.code == OURS or row.result != "answer":
        return ""
    if np.isinf(row.ours):
        return "ours less exact"
    return two_digits(row.seconds / row.ours)


_COLUMNS = {
    "contact": "name of the contact",
    "quantity": "quantity whose error is measured",
    "reference": "where its right value comes from",
    "code": "frictopt, a package of this process that is called directly, or a peer",
    "method": "method of the code",
    "setting": "discretisation and tolerance",
    "result": "'answer', or why there is none",
    "error": "relative error, at least 2.2e-16; inf without an answer",
    "seconds": "processor time, one thread: median of repetitions, or one run of a peer",
    "ours": "time of the fastest answer of frictopt whose error is no larger, in s; inf if none",
}
PEERS_TABLE = Table(
    "peers",
    "one contact by one code with one setting",
    _COLUMNS,
    full=FULL,
    quick=QUICK,
    compute=compared,
    options={
        "pythons": {
            "nargs": "+",
            "metavar": "PYTHON",
            "help": "interpreters to try for each peer, in this order",
        }
    },
    alone=True,
)
STUDY = Study(
    "studies.validation.peers",
    __doc__,
    "coarse meshes, in seconds",
    (PEERS_TABLE,),
    report,
)
