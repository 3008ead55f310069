"""A campaign in a process of its own, to be killed: `python campaign.py STORE TABLE`. It says when it starts a worker and which runs it has kept."""

import sys
from pathlib import Path

import numpy as np

import frictopt as fo
from frictopt.campaign import execute, random_slips
from frictopt.campaign.store import Store
from systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(0), 10)
STARTS = random_slips(CONTACT, [1.0], 50)
FACTORS = np.linspace(0.5, 2.0, 6)


def study(**options):
    return fo.dissipation_study(CONTACT, CYCLE, 0.3, FACTORS, STARTS, **options)


def telling(word, method, name):
    """A method that says what it has done."""

    def told(self, *args, **options):
        method(self, *args, **options)
        sys.stdout.write(f"{word} {name(self, *args)}\n")  # at once: threads say something, too
        sys.stdout.flush()

    return told


if __name__ == "__main__":
    store, table = map(Path, sys.argv[1:])
    Store.write = telling("kept", Store.write, lambda _, row: row["key"])
    execute._Worker.__init__ = telling("worker", execute._Worker.__init__, lambda worker, *_: worker.pid)
    try:
        study(workers=2, store=store).to_pickle(table)
    except KeyboardInterrupt as stop:
        stop.table.to_pickle(table)
        raise
