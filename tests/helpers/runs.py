"""Which runs of a study were followed, and which were taken from its store."""

import pandas as pd

import frictopt as fo


def results(table):
    """The table of a study without the times of its runs."""
    return table.drop(columns="seconds")


def same(table, other):
    """Two studies have the same results, to the last digit."""
    pd.testing.assert_frame_equal(results(table), results(other), check_exact=True)


def with_followed(store, ask):
    """The table of a study with a store, and the rows of the runs that it follows.

    The store gives the seconds that a run has taken to all later tables.
    """
    known = fo.results.read_store(store).seconds if store.exists() else []
    table = ask()
    return table, table[~table.seconds.isin(known)]
