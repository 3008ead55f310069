"""Solvers are loaded with the package."""

import subprocess
import sys


def test_a_highs_that_cannot_be_loaded_is_named_with_a_remedy(tmp_path):
    broken = "raise ImportError('undefined symbol: another HiGHS was first')"
    (tmp_path / "highspy.py").write_text(broken)
    program = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import frictopt.solve.solvers"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    last = ended.stderr.strip().splitlines()[-1]
    assert ended.returncode == 1
    assert last.startswith("ImportError: highspy cannot be loaded (undefined symbol")
    assert "import frictopt before it" in last
