"""Studies that hold the package against answers from elsewhere: oracles, random contacts, extremes, bare calls of other packages."""
