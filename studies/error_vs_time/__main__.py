"""Run the study from the command line."""

from . import STUDY

if __name__ == "__main__":
    raise SystemExit(STUDY.run())
