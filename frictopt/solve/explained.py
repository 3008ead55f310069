"""Answers that can print the program from which they come, with the names of its parts."""

from __future__ import annotations

from typing import Any

from ..base import Recorded, Table
from ..errors import ModelError


class Explained(Recorded):
    """Base class of answers that can print their program, with the names of its parts."""

    problem: Any

    def _explanation(self) -> tuple[str, float | None, Table | None, str]:
        """Title, answer, slips that limit the load, largest first, and the reason.

        The rows that bind are printed only if the objective of the problem still has the value of
        the answer, since the user may have solved the problem again for other data.
        """
        raise NotImplementedError

    def explain(self) -> str:
        """The model as text, with the names of its variables and constraints.

        The text shows their sizes and curvature, whether cvxpy compiles the problem once for all
        parameters (DPP), the constraints that bind, and what the model leaves out.
        """
        title, value, mechanism, reason = self._explanation()
        lines = [title, "=" * len(title)]
        if value is not None:
            lines.append(f"answer      {value:.12g}")
        if reason:
            lines.append(f"reason      {reason}")
        try:
            problem = self.problem
        except ModelError:
            # A limit with a gap has no problem, and files leave out a problem with user
            # constraints.
            problem = None
        if problem is None:
            lines.append("problem     none")
        else:
            # Imported here, because cvxpy is slow to import.
            from .problem import problem_lines

            lines += problem_lines(problem, value)
        lines.append("left out")
        lines += [f"    {text}" for text in self.record.left_out or ("nothing",)]
        if mechanism is not None and len(mechanism):
            shown = mechanism.head(8)
            lines.append(f"binding mechanism, {len(shown)} of {len(mechanism)} slips")
            table = shown.to_string(index=False, float_format="{:.4g}".format)
            lines += [f"    {row}" for row in table.split("\n")]
        return "\n".join(lines)
