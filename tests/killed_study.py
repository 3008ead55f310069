"""A study in a process of its own, to be killed: `python killed_study.py STORE TABLE [executor | dying]`. It says which runs it has kept."""

import os
import signal
import sys
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import frictopt as fo
from frictopt.histories.store import Store
from systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(0), 10)
STARTS = fo.starts.random_slips(CONTACT, [1.0], 50)
FACTORS = np.linspace(0.5, 2.0, 6)


def study(**options):
    return fo.dissipation_study(CONTACT, CYCLE, 0.3, FACTORS, STARTS, **options)


def telling(write, pool, dying):
    """Writes that say so; the pool loses a process after 20 of them if it is dying."""
    count = 0

    def told(self, row):
        nonlocal count
        write(self, row)
        print(row["key"], flush=True)
        count += 1
        if dying and count == 20:
            os.kill(next(iter(pool._processes)), signal.SIGKILL)

    return told


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # shells begin jobs in the background so that they do not hear Ctrl-C
    store, table, *pool = sys.argv[1:]
    with ProcessPoolExecutor(1, get_context("spawn")) if pool else nullcontext() as executor:
        Store.write = telling(Store.write, executor, pool == ["dying"])
        try:
            study(executor=executor, store=store).to_pickle(table)
        except KeyboardInterrupt as stop:
            stop.table.to_pickle(Path(table))
            raise
