"""Studies that compare the package with independent answers: oracles, random contacts, extreme input, direct calls of other packages."""
