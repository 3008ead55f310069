"""What is called proven, or said of every slip or every start, attacked by starts and loads that
break its condition; and the page that lists it."""

import ast
import inspect
import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import limit_of_set, pose, with_open
from frictopt.limits.answers import sentences
from frictopt.limits.search.likely_sets import open_under_mean
from helpers.separation import lifted_system, open_in_space, pulled_system, resting_starts
from helpers.systems import CYCLE, system, unit_nodes
from studies import first_look

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "claims.md").read_text(encoding="utf-8")
SPEC = spec_from_file_location("claims", ROOT / "docs" / "claims.py")
sys.modules["claims"] = claims = module_from_spec(SPEC)
SPEC.loader.exec_module(claims)
CLAIM = re.compile(
    r"safe (above|at|below|with)\b|are safe|has a safe|B = 0|lambda_1 is|critical below|for ever|no friction"
    r"|finds no|with others|no limit:|is infinite"
)
STRONG = re.compile(
    r"theorem|from both sides|whatever (its|the) start|from every start|shakedown is certain"
)
# Words of front pages that claim something of all starts or all time, and the words of the
# conditions that `covers`, `bound_for_all` and `proven` of the same answer have.
ALL_STARTS = re.compile(
    r"\b(every|each|all|any|no|whatever( its| the)?) starts?\b|\bfor ever\b|\bnever (stop|slip)",
    re.I,
)
CONDITION = re.compile(
    r"clos|\bopens?\b|proven|observ|uncoupled|theorem|B = 0|B\$? = 0|overload|may slip|not from every",
    re.I,
)
# A slip is safe, a load or a joint is not; only a limit is called guaranteed.
BEHAVIOUR = re.compile(r"\b(slip|stick|stop|rest|keep|goes)", re.I)
SAFE_WITHOUT_SLIP = re.compile(r"(?!.*slip)(?!.*safe region)(?!.*\?$).*\bsafe\b", re.I)
OTHER_GUARANTEE = re.compile(r"\bguarantee(?!d(\*|_| )*(limit|problem))", re.I)
FRONT_PAGES = [
    ROOT / "README.md",
    ROOT / "docs" / "index.md",
    ROOT / "docs" / "faq.md",
    *sorted((ROOT / "docs" / "tutorial").glob("*.md")),
]
PLACES = [
    ROOT / "README.md",
    *sorted(
        path
        for path in (ROOT / "docs").rglob("*.md")
        if not {"_build", "tables", "writeups"} & set(path.parts)
    ),
]


def contact_of(S, loads, points, gap=None):
    return fo.ContactSystem(S, points, loads, gap=gap)


def uncoupled(rng):
    """A random contact with B = 0, its nodes closed or some of them open under the mean load."""
    contact = pulled_system(rng, int(rng.integers(2, 5)))
    S, n = contact.S.copy(), contact.nodes
    S[n:, :n] = S[:n, n:] = 0.0
    return contact_of(
        S,
        {name: np.concatenate(r) for name, r in contact.bonded.items()},
        contact.points,
        contact.gap,
    ), rng.uniform(0.2, 1.0, n)


def closed_nodes_uncoupled(rng):
    """A random coupled contact whose closed nodes, left alone by those that the mean load opens,
    are uncoupled; None without open nodes."""
    contact = pulled_system(rng, n := int(rng.integers(2, 5)))
    friction, S = rng.uniform(0.2, 1.0, n), contact.S.copy()
    opened = fo.shakedown_limit(contact, CYCLE, friction).open
    if not opened.any():
        return None
    out, m = np.tile(opened, 2), int((~opened).sum())
    through = S[np.ix_(~out, out)] @ np.linalg.solve(S[np.ix_(out, out)], S[np.ix_(out, ~out)])
    left = S[np.ix_(~out, ~out)] - through
    left[m:, :m] = left[:m, m:] = 0.0
    S[np.ix_(~out, ~out)] = left + through
    return contact_of(
        S,
        {name: np.concatenate(r) for name, r in contact.bonded.items()},
        contact.points,
        contact.gap,
    ), friction


def slips_for_ever(contact, friction, limit, rng, starts=8):
    """Whether some of random starts, which open and close nodes, slips for ever below a guaranteed
    limit."""
    for k in range(starts):
        load_factor = limit.least + (0.9, 0.5)[k % 2] * (limit.load_factor - limit.least)
        start = rng.normal(size=contact.nodes) * 10 ** rng.uniform(-1, 1.5)
        try:
            steady = fo.steady_state(contact, CYCLE, friction, load_factor, initial_slip=start)
        except fo.NoContinuation:
            continue
        if steady.outcome is not fo.Outcome.SHAKEDOWN:
            return True
    return False


def attacked(make, seeds):
    """Of random contacts with a guaranteed limit to attack: how many say `proven`, and how many
    slip for ever and say it or not."""
    count = {"asked": 0, "proven": 0, "proven, slips": 0, "not proven, slips": 0}
    for seed in seeds:
        rng = np.random.default_rng(seed)
        if (made := make(rng)) is None:
            continue
        limit = fo.guaranteed_limit(made[0], CYCLE, made[1])
        if not limit.least + 1e-6 < limit.load_factor < np.inf:
            continue
        count["asked"] += 1
        count["proven"] += limit.proven
        assert ("B = 0" in limit.reason) == limit.proven
        if slips_for_ever(*made, limit, rng):
            count["proven, slips" if limit.proven else "not proven, slips"] += 1
            assert (
                "starts with nodes that open and close in every cycle may slip for ever below it"
                in limit.reason
            )
    return count


def test_a_proven_guaranteed_limit_holds_from_starts_that_open_and_close_nodes():
    """Where B is zero it is said, and holds, with nodes open under the mean load too."""
    count = attacked(uncoupled, range(20))
    assert count["proven"] == count["asked"] > 15 and not count["proven, slips"]


def test_a_guaranteed_limit_is_not_proven_where_the_closed_nodes_alone_are_uncoupled():
    count = attacked(closed_nodes_uncoupled, [14, 43, 84])
    assert count["proven"] == 0 and count["not proven, slips"] >= 3


def test_nodes_that_the_mean_load_opens_couple_once_a_start_closes_them():
    """Node 1 is closed and by symmetry alone uncoupled; the nodes beside it touch after a start."""
    S = [
        [0.85, 0.08, -0.42, -0.32, -0.96, -0.1],
        [0.08, 1.37, 0.08, 0.24, 0.0, -0.24],
        [-0.42, 0.08, 0.85, 0.1, 0.96, 0.32],
    ]
    S += [
        [-0.32, 0.24, 0.1, 2.62, -0.69, 0.57],
        [-0.96, 0.0, 0.96, -0.69, 2.87, -0.69],
        [-0.1, -0.24, 0.32, 0.57, -0.69, 2.62],
    ]
    loads = {
        "m": [0, 0, 0, 0.01, 1, 0.01],
        "a": [1.8, 1, 1.8, -0.06, 0, 0.06],
        "c": [0, 0, 0, 0.3, 0.5, 0.3],
    }
    contact = contact_of(S, loads, [[-1, 0], [0, 0], [1, 0]], [0.21, 0, 0.21])
    cycle = fo.LoadCycle({"m": 1.0}, [{"a": 1.0, "c": 1.3}, {"a": -1.0}])
    limit = fo.guaranteed_limit(contact, cycle, 0.8)
    steady = fo.steady_state(
        contact, cycle, 0.8, 0.5 * limit.load_factor, initial_slip=[0.5, 2.5, -1.0]
    )
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP and limit.open.tolist() == [True, False, True]
    assert (
        not limit.proven
        and "B = 0" not in limit.reason
        and limit.load_factor == limit.shakedown.load_factor
    )


def test_a_node_without_friction_couples_the_others_once_a_start_opens_it():
    """f B is zero, B is not."""
    S = [[0.6, 0, -0.3, 0, 0, 0.2], [0, 0.9, 0.1, 0, 0, -0.3], [-0.3, 0.1, 2.4, 0, 0, -0.5]]
    S += [[0, 0, 0, 1.0, 0.2, -0.2], [0, 0, 0, 0.2, 1.0, -0.1], [0.2, -0.3, -0.5, -0.2, -0.1, 0.6]]
    contact = contact_of(
        S, {"m": [0, 0, 0, 0.1, 1, 0.1], "a": [2.8, 1.3, 0, 0.7, 0.4, 0]}, [[0, 0], [1, 0], [2, 0]]
    )
    cycle, friction = fo.LoadCycle({"m": 1.0}, [{"a": 1.0}, {"a": -1.0}]), [0.5, 0.5, 0.0]
    limit = fo.guaranteed_limit(contact, cycle, friction)
    steady = fo.steady_state(
        contact, cycle, friction, 0.9 * limit.load_factor, initial_slip=[-46.0, 49.0, 66.4]
    )
    assert (
        steady.outcome is fo.Outcome.CYCLIC_SLIP
        and not limit.proven
        and "B = 0" not in limit.reason
    )
    assert "may slip for ever below it" in limit.reason


@pytest.mark.parametrize("coupling", [0.0, 1e-9, 0.5])
def test_without_any_friction_a_contact_is_uncoupled_only_where_it_is(coupling):
    contact = system(
        np.eye(2), coupling * np.array([[0.0, 1.0], [-1.0, 0.0]]), 0.0, 1.0, 0.0, [0.2, -0.2]
    )
    limit = fo.guaranteed_limit(contact, CYCLE, 0.0)
    assert limit.proven == (coupling == 0) == (
        "B = 0" in limit.reason
    ) and limit.load_factor == pytest.approx(5.0)


def test_where_nothing_is_safe_nothing_is_proven_of_starts():
    """One node of B = 0, pulled open by 0.5, pressed by 1 and sheared by less than friction at one
    corner: it opens and closes, and never slips."""
    loads = {"P": ([0.0], [-0.5]), "N": ([0.4], [1.0]), "X": ([0.01], [0.0])}
    node = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {}], fixed=[{"N": 1.0}, {}])
    limit, steady = fo.guaranteed_limit(node, cycle, 0.5), fo.steady_state(node, cycle, 0.5, 1.0)
    assert steady.outcome is fo.Outcome.SHAKEDOWN and steady.dissipation == 0
    assert limit.proven and "no state of rest exists above it" in limit.reason
    above = fo.steady_state(node, cycle, 0.5, 1.01 * limit.load_factor)
    assert limit.load_factor > 1 and above.outcome is fo.Outcome.CYCLIC_SLIP
    coupled = fo.ContactSystem.from_blocks([[1.0]], [[0.01]], [[1.0]], [0.0], loads)
    nothing = fo.guaranteed_limit(coupled, cycle, 0.5)
    assert nothing.kind is fo.LimitKind.NO_SAFE_SLIP and not nothing.proven
    assert nothing.reason.startswith(
        "no residual slip is safe at any load factor with all nodes closed"
    )


@pytest.mark.parametrize("seed", [2, 8, 9])
def test_a_closed_contact_rests_above_its_bound_with_nodes_that_open_and_close(seed):
    """So `bound`, and that no residual slip is safe, are said of all nodes closed."""
    rng = np.random.default_rng(seed)
    contact = lifted_system(rng, int(rng.integers(2, 5)), coupling=0.5, by=4)
    limit = fo.shakedown_limit(contact, CYCLE, 0.6)
    assert not limit.open.any() and limit.bound < 1.01 * limit.load_factor
    assert resting_starts(contact, CYCLE, 0.6, 1.05 * limit.bound, limit.slip, 12, rng)
    assert limit.reason.startswith("no residual slip is safe above it with all nodes closed")


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_under_a_static_load_a_contact_rests_above_its_bound(seed):
    """One corner: from no slip it comes to rest at 1.2 of the limit with all nodes closed, with
    some node open."""
    rng = np.random.default_rng(seed)
    contact = lifted_system(rng, int(rng.integers(2, 5)), coupling=0.5)
    up = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}])
    closed = limit_of_set(pose(contact, up, 0.5))
    steady = fo.steady_state(contact, up, 0.5, 1.2 * closed.bound)
    assert steady.outcome is fo.Outcome.SHAKEDOWN and closed.reason.startswith(
        "no residual slip is safe above it with all nodes closed"
    )
    found = fo.shakedown_limit(contact, up, 0.5)
    assert closed.reason.endswith("load factor at which a body slides off (bound_for_all)")
    assert found.load_factor >= 1.2 * closed.bound and found.best_of_all
    assert found.bound_for_all >= 1.2 * closed.bound


def test_with_other_nodes_open_a_contact_rests_above_its_bound():
    contact, cycle, limit = open_in_space(1, nodes=9)
    mean = limit_of_set(
        with_open(pose(contact, cycle, 0.6), open_under_mean(pose(contact, cycle, 0.6))[0])
    )
    assert (
        limit.load_factor > 1.2 * mean.bound
        and "is safe above it with these nodes open" in mean.reason
    )
    assert (
        "is safe above it with these nodes open and the others closed; with other nodes open it may be higher"
        in limit.reason
    )


def claims_of(path):
    """Texts of a file that claim. Docstrings, and what a sentence assumes, are no claims."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    no_claims = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
        if is_text and id(node) not in no_claims and CLAIM.search(node.value):
            yield claims.shortened(node.value)


def test_the_page_is_made_from_its_claims():
    """Otherwise run `python docs/claims.py`."""
    assert claims.page(PAGE) == PAGE


def test_every_sentence_has_a_claim():
    """Otherwise give it a claim in `docs/claims.py`, with a source and a test."""
    named = [name for claim in claims.CLAIMS for name in claim.sentences.split()]
    assert len(named) == len(set(named))
    said = {f"answers.sentences.{name}" for name in vars(sentences) if name.isupper()}
    assert len(said) > 60 and said <= set(named)
    assert said == set(claims.ASSUMED)


def test_every_text_of_limits_that_claims_is_on_the_page():
    texts = [
        text for path in (ROOT / "frictopt" / "limits").rglob("*.py") for text in claims_of(path)
    ]
    assert len(texts) > 20
    assert not [
        text for text in texts if any(piece.strip(" ;:,") not in PAGE for piece in text.split("…"))
    ]


def test_pages_and_docstrings_that_claim_are_named_on_the_page():
    for path in PLACES:
        if STRONG.search(path.read_text(encoding="utf-8")) and path.name != "claims.md":
            name = (
                path.relative_to(ROOT / "docs").as_posix() if path.name != "README.md" else "README"
            )
            assert f"{name.removesuffix('.md')}" in PAGE, path
    public = {
        name: getattr(module, name)
        for module in (fo, fo.fem, fo.joints, fo.readers, fo.results, fo.reference)
        for name in module.__all__
    }
    members = {
        name: value
        for thing in public.values()
        if inspect.isclass(thing)
        for name, value in vars(thing).items()
        if name[0] != "_"
    }
    for name, thing in (members | public).items():
        if inspect.isroutine(thing) or inspect.isclass(thing) or isinstance(thing, property):
            assert not STRONG.search(inspect.getdoc(thing) or "") or f"`{name}`" in PAGE, name


def test_every_claim_has_a_test_that_exists():
    files = {path.stem: path for path in (ROOT / "tests").rglob("test_*.py")}
    for claim in claims.CLAIMS:
        assert claim.tests
        for test in claim.tests.split():
            file, name = test.split("::")
            text = files[file].read_text(encoding="utf-8")
            assert re.search(rf"^def {name}\(", text, re.MULTILINE), test


def sentences_of_page(page):
    """Sentences of text, and of comments and strings in code."""
    blocks = re.split(r"^```(.*)\n((?:.*\n)*?)```$", page, flags=re.MULTILINE)
    texts = []
    for text, head, code in zip(blocks[::3], [*blocks[1::3], ""], [*blocks[2::3], ""], strict=True):
        texts += re.split(r"\n\s*\n|\n(?=[-|#>] ?)|\n", text)
        if "python" in head:
            texts += re.findall(r"#.*|\"[^\"\n]*\"", code)
        elif "{" in head:
            texts += code.splitlines()
    return [
        sentence
        for text in texts
        for sentence in re.split(r"(?<=[.:!?]) +(?=[A-Z`*\[])", re.sub(r"\]\([^)]*\)", "]", text))
    ]


def without_condition(sentence):
    """Whether a sentence claims more than the answers of which it speaks."""
    words = re.sub(r"`[^`]*`", "", sentence)
    of_all = ALL_STARTS.search(words) and BEHAVIOUR.search(words)
    return bool(
        (of_all and not CONDITION.search(sentence))
        or SAFE_WITHOUT_SLIP.match(words)
        or OTHER_GUARANTEE.search(words)
    )


@pytest.mark.parametrize("page", FRONT_PAGES, ids=lambda page: page.stem)
def test_front_pages_claim_no_more_than_the_answers(page):
    """Otherwise name the condition in the sentence itself: readers take single sentences along."""
    said = sentences_of_page(page.read_text(encoding="utf-8"))
    assert len(said) > 8 and not [sentence for sentence in said if without_condition(sentence)]


def test_the_first_command_and_its_picture_claim_no_more_than_the_answers():
    tree = ast.parse(inspect.getsource(first_look))
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    said = [
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in docstrings
    ]
    assert any(ALL_STARTS.search(text) for text in said)
    assert not [text for text in said if without_condition(text)]


@pytest.mark.parametrize(
    ("said", "too_much"),
    [
        ("Above the shakedown limit every start slips in every cycle.", True),
        ("Above it every start slips in every cycle, if all nodes stay closed.", False),
        ("Below the *guaranteed limit* the contact stops slipping from every start.", True),
        ("Below it slip stops from every start: observed, not proven.", False),
        ("the flank slips for ever", True),
        ("# largest safe sway, proven from both sides", True),
        ("the largest sway with a safe slip", False),
        ("how much friction makes it safe", True),
        ("A load below the limit is guaranteed.", True),
    ],
)
def test_a_sentence_without_its_condition_is_noticed(said, too_much):
    assert without_condition(said) == too_much
