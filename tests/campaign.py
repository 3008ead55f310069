"""A campaign in a process of its own, to be killed: `python campaign.py STORE TABLE`."""

import os
import sys
from pathlib import Path

import numpy as np

import frictopt as fo
from frictopt.study import random_slips
from systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(0), 10)
STARTS = random_slips(CONTACT, [1.0], 100)
FACTORS = np.linspace(0.5, 2.0, 6)


def study(**options):
    return fo.dissipation_study(CONTACT, CYCLE, 0.3, FACTORS, STARTS, **options)


def end(*_):
    """Set-up of a worker for which there is no memory."""
    os._exit(1)


if __name__ == "__main__":
    store, table = map(Path, sys.argv[1:])
    study(workers=2, store=store).to_parquet(table)
