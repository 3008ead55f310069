"""Files whose numbers were changed, with right checksums, are refused; `frictopt check` says why."""

import json
import zipfile

import numpy as np
import pytest

import frictopt as fo
from helpers.command import main
from helpers.systems import CYCLE, block, random_system, uncoupled

SYSTEM = random_system(np.random.default_rng(3), 3)
PUSHED = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
ANSWERS = {
    "limit": fo.shakedown_limit(SYSTEM, CYCLE, 0.5),
    "steady": fo.steady_state(SYSTEM, CYCLE, 0.5, 1.0, progress=False),
    "required": fo.required_friction(SYSTEM, CYCLE, 0.1, progress=False),
    "safe": fo.safe_slip(SYSTEM, CYCLE, 0.5, 0.1),
    "guaranteed": fo.guaranteed_limit(SYSTEM, CYCLE, 0.5),
    "equal": fo.guaranteed_limit(uncoupled(np.random.default_rng(1), 3, 1)[0], CYCLE, 0.5),
    "infinite": fo.shakedown_limit(SYSTEM, fo.LoadCycle({"mean": 1.0}, [{"mean": 2.0}]), 0.5),
    "none": fo.shakedown_limit(SYSTEM, fo.LoadCycle({"mean": -1.0}, CYCLE.corners), 0.5),
    "block": fo.gross_slip(block(np.random.default_rng(1)), PUSHED, 0.3, progress=False),
    "path": fo.march(SYSTEM, CYCLE, 0.5, 1.0, cycles=1, progress=False),
}


def changed(path, change, sealed=False):
    """Rewrite a result; `change` gets its arrays, and the fields of the things by class."""
    with np.load(path) as archive:
        arrays = dict(archive)
    if not sealed:
        del arrays["seal"]
    text, things = json.loads(arrays["text"].tobytes())
    by_class = {kind: dict(content) for thing in things for kind, content in thing.items()}
    change(arrays, by_class)
    things = [{kind: [*by_class[kind].items()] for kind in thing} for thing in things]
    arrays["text"] = np.frombuffer(json.dumps([text, things]).encode(), np.uint8)
    np.savez(path, **arrays)


def of_array(kind, name, change):
    def made(arrays, things):
        place = f"array {things[kind][name]['array']}"
        arrays[place] = np.asarray(change(arrays[place]))

    return made


def of_field(kind, name, value):
    return lambda arrays, things: things[kind].update({name: value})


def each_of(*changes):
    return lambda arrays, things: [change(arrays, things) for change in changes] and None


def without_end(kind):
    """A limit of another kind, with its numbers."""
    return [
        of_field(LIMIT, "kind", {"LimitKind": kind}),
        *(of_field(LIMIT, name, NUMBERS[kind]) for name in ("load_factor", "bound")),
    ]


LIMIT, STEADY, GUARANTEED = "ShakedownLimit", "SteadyState", "GuaranteedLimit"
NUMBERS = {"UNBOUNDED": np.inf, "NO_SAFE_SLIP": np.nan}
FACTOR = ANSWERS["limit"].load_factor
CHANGES = {
    "load factor": ("limit", of_field(LIMIT, "load_factor", 1000 * FACTOR), "slip violates"),
    "less": ("limit", of_field(LIMIT, "load_factor", 0.9 * FACTOR), "its mechanism proves"),
    "bound": ("limit", of_field(LIMIT, "bound", 0.9 * FACTOR), "its mechanism proves"),
    "least": ("limit", of_field(LIMIT, "least", 2 * FACTOR), "least load factor"),
    "kind": ("limit", of_field(LIMIT, "kind", {"LimitKind": "UNBOUNDED"}), "its kind"),
    "limitless": ("limit", each_of(*without_end("UNBOUNDED")), "leaves the contact law by"),
    "unsafe": ("limit", each_of(*without_end("NO_SAFE_SLIP")), "mechanism does not prove"),
    "safe": ("none", each_of(*without_end("UNBOUNDED")), "leaves the contact law by"),
    "turned": ("none", of_array("Mechanism", "moves", lambda d: -d), "does not prove"),
    "guaranteed": ("guaranteed", of_field(GUARANTEED, "load_factor", 0.1), "its critical state"),
    "node": ("guaranteed", of_field(GUARANTEED, "node", 0), "its critical state"),
    "other nodes": ("guaranteed", of_array(GUARANTEED, "_by_node", lambda b: b / 2), "other lim"),
    "proven": ("guaranteed", of_field(GUARANTEED, "proven", True), "other limits"),
    "not proven": ("equal", of_field(GUARANTEED, "proven", False), "other limits"),
    "both": ("equal", of_field(GUARANTEED, "load_factor", 0.0), "other limits"),
    "slide": ("block", of_field("GrossSlip", "bound", 2.0), "its motion does not prove"),
    "strain": ("block", of_array("GrossSlip", "phi", lambda d: d * np.arange(5)), "not prove"),
    "lift": ("block", of_array("GrossSlip", "phi", lambda d: d[::-1]), "does not prove"),
    "beyond": ("block", of_field("GrossSlip", "load_factor", 2.0), "its motion does not prove"),
    "text": ("limit", of_field(LIMIT, "load_factor", "0.5"), "load_factor is a str"),
    "true": ("limit", of_field(LIMIT, "load_factor", True), "load_factor is a bool"),
    "nan": ("limit", of_array(LIMIT, "slip", lambda slip: slip * np.nan), "slip violates"),
    "short": ("limit", of_array(LIMIT, "slip", lambda slip: slip[:-1]), "shape"),
    "words": ("limit", of_array(LIMIT, "slip", lambda slip: slip.astype(str)), "is a ndarray"),
    "motion": ("limit", of_array("Mechanism", "moves", lambda d: d[:, :, ::-1]), "proves nan"),
    "stiffness": ("limit", of_array("ContactSystem", "S", lambda S: S + np.eye(6)), "its"),
    "friction": ("limit", of_array("Question", "friction", lambda f: 0.9 * f), "slip violates"),
    "contact": ("steady", of_array(STEADY, "gap", lambda w: w - 1), "violates the contact law"),
    "work": ("steady", of_field(STEADY, "dissipation", 0.0), "its nodes dissipate"),
    "frictions": ("required", of_array("Question", "friction", lambda f: f / 2), "violates"),
    "required": ("required", of_field("RequiredFriction", "required", 1e-3), "its slip another"),
    "too little": ("required", of_field("RequiredFriction", "bound", 1e-3), "is not enough"),
    "margin": ("safe", of_field("SafeSlip", "margin", 2.0), "the reserve of its slip"),
    "less margin": ("safe", of_field("SafeSlip", "margin", -1.0), "the bound of it"),
    "amplitude": ("safe", of_field("SafeSlip", "load_factor", 10.0), "slip violates"),
    "states": ("path", of_array("Trajectory", "p", lambda p: 2 * p), "states violate"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_numbers_that_do_not_hold_are_refused(name, tmp_path, capsys):
    kind, change, why = CHANGES[name]
    file = str(tmp_path / "answer.npz")
    ANSWERS[kind].save(file)
    assert fo.results.load(file) is not None
    changed(file, change)
    with pytest.raises(fo.ModelError, match=f"is not a result .*{why}"):
        fo.results.load(file)
    assert main(["check", file]) == 2
    assert "is not a result" in capsys.readouterr().err


def test_a_slip_of_any_size_is_read_if_large_friction_holds_it(tmp_path):
    """Its forces, 1e8 times those of the loads, are known up to rounding alone."""
    system = random_system(np.random.default_rng(19), 3)
    answer = fo.required_friction(system, CYCLE, 5.0, progress=False)
    assert answer.largest_slip > 1e6
    answer.save(tmp_path / "answer.npz")
    assert fo.results.load(tmp_path / "answer.npz").required == answer.required


def test_an_array_that_holds_as_well_is_seen_to_be_another(tmp_path):
    """The limit of a stiffer contact without coupling is the same limit."""
    file = tmp_path / "limit.npz"
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    fo.shakedown_limit(rod, cycle, 0.5).save(file)
    changed(file, of_array("ContactSystem", "S", lambda S: 100 * S), sealed=True)
    with pytest.raises(fo.ModelError, match="it was changed after it was written"):
        fo.results.load(file)


def test_of_two_members_of_one_name_none_is_read(tmp_path):
    SYSTEM.save(tmp_path / "system.npz")
    with pytest.warns(UserWarning), zipfile.ZipFile(tmp_path / "system.npz", "a") as archive:
        archive.writestr("S.npy", archive.read("S.npy"))
    with pytest.raises(fo.ModelError, match="two of its members have one name"):
        fo.ContactSystem.load(tmp_path / "system.npz")


def test_a_check_says_version_date_and_input(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ANSWERS["limit"].save("limit.npz")
    SYSTEM.save("system.npz")
    fo.report(SYSTEM, CYCLE, 0.5, pages=1, progress=False).save("joint.json")
    fo.dissipation_study(SYSTEM, CYCLE, 0.5, [1.0], store="runs.sqlite", progress=False)
    says = {
        "limit.npz": ["ContactSystem(nodes=3", "LoadCycle(mean={'mean': 1.0}", "friction"],
        "system.npz": ["ContactSystem(nodes=3"],
        "joint.json": ["friction 0.5"],
        "runs.sqlite": ["1 run of version", "CYCLIC_SLIP", "friction 0.5"],
    }
    for file, words in says.items():
        assert main(["check", file]) == 0
        said = capsys.readouterr().out
        assert f"{file}: holds" in said
        assert f"of version {fo.__version__}" in said
        assert all(word in said for word in words), said


def test_a_report_that_was_changed_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    fo.report(SYSTEM, CYCLE, 0.5, pages=1, progress=False).save("joint.json")
    with open("joint.json", encoding="utf-8") as file:
        content = json.load(file)
    content["safety"][0]["nominal"] = 1000.0
    with open("joint.json", "w", encoding="utf-8") as file:
        json.dump(content, file)
    assert main(["check", "joint.json"]) == 2 and "was changed" in capsys.readouterr().err
    with open("joint.json", "w", encoding="utf-8") as file:
        file.write("[" * 100_000)
    assert main(["check", "joint.json"]) == 2 and "not a report" in capsys.readouterr().err


def test_small_files_cannot_fill_the_memory(tmp_path):
    file = tmp_path / "limit.npz"
    ranges = {"tuple": {"range": {"list": [0, 10**15, 1]}}}
    text = np.frombuffer(json.dumps([ranges, []]).encode(), np.uint8)
    np.savez(file, format="frictopt result 1", version=fo.__version__, text=text)
    with pytest.raises(fo.ModelError, match="a tuple of a dict"):
        fo.results.load(file)
    np.savez_compressed(file, format="frictopt result 1", text=np.zeros(150_000_000, np.uint8))
    with pytest.raises(fo.ModelError, match="would grow to"):
        fo.results.load(file)
    with zipfile.ZipFile(file, "w") as archive, archive.open("text.npy", "w") as member:
        promise = {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}
        np.lib.format.write_array_header_1_0(member, promise)
    with pytest.raises(fo.ModelError, match=r"text\.npy is damaged"):
        fo.results.load(file)
