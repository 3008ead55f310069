"""Reading of joints: from decks, and from joint files in TOML."""

from collections.abc import Mapping
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Any, Literal, get_args

from ..base import choice, flag
from ..base.entries import by_names, checked_entries, known, made, read_toml
from ..base.files import file_path
from ..errors import ModelError
from ..fem.bodies import split_bodies
from ..fem.contacts import Contact, Tie
from ..fem.couplings import Coupling
from ..fem.elasticity import Material
from ..fem.load_cases import Load
from ..fem.model import ContactModel
from ..fem.sector import Cyclic
from ..fem.supports import Support
from ..readers.deck_text import blocks, flat
from ..readers.keywords import read_deck
from ..readers.meshes import read_mesh
from ..study.plans import named_distribution
from .deck_conditions import Conditions
from .deck_model import DeckModel
from .joint import Joint
from .refused import check_not_refused
from .states import load_cases

# Entries of a joint file, and their kinds in TOML.
_OF_ALL: dict[str, type] = {
    "title": str,
    "units": str,
    "cycle": dict,
    "friction": dict,
    "preload": dict,
    "load": object,
    "correlation_length": object,
    "limits": dict,
}
_OF_DECK = {"deck": str, "elastic": bool, "stiffness": str, **_OF_ALL}
_OF_MESH = {
    "mesh": str,
    "kinematics": str,
    "thickness": float,
    "materials": dict,
    "bodies": dict,
    "contacts": list,
    "supports": list,
    "loads": dict,
    "ties": list,
    **_OF_ALL,
}
_NEEDED = ("materials", "bodies", "contacts", "loads")
_OF_CYCLE = ("mean", "corners", "harmonic", "points")
_STIFFNESS = ("rigid", "deck")
_LOADS = {kind.__name__: kind for kind in get_args(Load)}
_SUPPORTS = {kind.__name__: kind for kind in (Support, Cyclic, *get_args(Coupling))}


def read_joint(
    path: str | Path, *, elastic: bool = False, stiffness: Literal["rigid", "deck"] = "rigid"
) -> Joint:
    """Read a joint from a deck of CalculiX or Abaqus, or from a joint file.

    From a deck come bodies, contacts, friction, loads and steps.

    Each `*CONTACT PAIR` is a contact whose body 1 is the slave; its name is SLAVE-MASTER. Loads of
    a set, such as "CLOAD NSIDE", are load cases, and the end of each static step is a state: the
    amplitudes of the load cases that are in force. The page "What is read of a file" lists all
    keywords.

    A joint file adds to a deck what the deck does not say, or describes a joint whose mesh is in a
    file; see "The command line".

    Parameters
    ----------
    path
        The deck, `.inp`, or the joint file, `.toml`.
    elastic
        Whether to leave out the plasticity and creep of materials. Otherwise they are refused.
    stiffness
        "rigid": faces are rigid, and the contact stiffness of a deck is left out. "deck": contacts
        have the stiffness that the deck gives by `*SURFACE BEHAVIOR` (LINEAR) and by the stick
        slope of `*FRICTION`, see `Contact`.

    Returns
    -------
    Joint
        Its `model`, `system()`, `states`, `friction` and `cycle(...)`, and what is `left_out`.

    Raises
    ------
    ModelError
        The deck has something that a joint cannot have: the error has the line, the keyword, and
        the change that helps. It has no contact pair or no static step. `ContactModel` refuses the
        model.

    Examples
    --------
    >>> import frictopt as fo
    >>> joint = fo.read_joint("tests/data/block.inp")
    >>> cycle = joint.cycle("STEP 1", ["STEP 2", "STEP 3"])
    >>> round(fo.gross_slip(joint.system(), cycle, joint.friction).load_factor, 6)
    1.333333
    """
    flag("elastic", elastic)
    choice("stiffness", stiffness, _STIFFNESS)
    file = file_path("path", path)
    ending = file.suffix.lower()
    if ending == ".toml":
        return _joint_of_file(file, elastic, stiffness)
    if ending != ".inp":
        raise ModelError(f"path: {str(path)!r}; give a deck of CalculiX or Abaqus, .inp, or .toml")
    return _joint_of_deck(file, elastic, stiffness)


def _joint_of_deck(file: Path, elastic: bool, stiffness: str) -> Joint:
    listed = list(flat(blocks(file)))
    for block in listed:
        check_not_refused(block, elastic=elastic)
    deck = read_deck(file, mesh_alone=True)
    conditions = Conditions(deck, listed, is_rough=stiffness == "deck")
    if not conditions.states:
        raise ModelError(f"deck {file.name}: no *STATIC step; a joint needs one")
    cases, states = load_cases(conditions.states)
    try:
        deck_model = DeckModel(conditions, cases, file.name)
        model = deck_model.model(cases)
    except ModelError as error:
        raise ModelError(f"deck {file.name}: {error}") from error
    # The overlaps of a fit are in force in all states.
    amplitudes = {
        name: {case: size for case, size in {"FIT": 1.0, **loads}.items() if case in model.loads}
        for name, loads in states.items()
    }
    return Joint(
        file.name,
        model,
        deck_model.thickness if deck_model.is_plane else None,
        amplitudes,
        deck_model.friction,
        deck_model.interactions,
        [*conditions.left_out],
        [state.name for state in conditions.states if state.setting != deck_model.setting],
        [state.name for state in conditions.states if state.locked],
    )


def _joint_of_file(file: Path, elastic: bool, stiffness: str) -> Joint:
    """The joint of a joint file: a deck with additions, or a mesh with everything else."""
    tables = read_toml(file)
    if "deck" in tables:
        tables = checked_entries(file.name, tables, _OF_DECK)
        deck = file.parent / str(tables["deck"])
        stiffness = choice("stiffness", tables.get("stiffness", stiffness), _STIFFNESS)
        joint = _joint_of_deck(deck, tables.get("elastic", elastic), stiffness)
    elif "mesh" in tables:
        tables = checked_entries(file.name, tables, _OF_MESH, _NEEDED)
        joint = _joint_of_mesh(file, tables)
    else:
        raise ModelError(f"{file.name}: neither deck nor mesh; name the file of one")
    asked = by_names(f"{file.name}: cycle: entry", tables.get("cycle", {}), _OF_CYCLE)
    friction = _scatters("friction", tables.get("friction", {}))
    of_report: dict[str, Any] = {
        name: tables[name] for name in ("title", "limits", "correlation_length") if name in tables
    }
    if "preload" in tables:
        of_report["preload"] = _scatters("preload", tables["preload"])
    if "load" in tables:
        of_report["load"] = _scatter("load", tables["load"])
    return replace(
        joint,
        name=file.name,
        friction=joint.friction_with(friction),
        units=tables.get("units"),
        asked=asked,
        of_report=of_report,
    )


def _joint_of_mesh(file: Path, tables: Mapping[str, Any]) -> Joint:
    """The joint of a mesh and of tables, each of which has the arguments of a class."""
    materials = {
        name: made(f"materials.{name}", Material, table)
        for name, table in tables["materials"].items()
    }
    bodies = {
        body: materials[known(f"bodies.{body}: material", name, materials)]
        for body, name in tables["bodies"].items()
    }
    contacts = []
    coefficients = {}
    for table in tables["contacts"]:
        friction = 0.0
        if isinstance(table, dict):
            table = by_names("contacts", table, [*signature(Contact).parameters, "friction"])
            friction = table.pop("friction", friction)
        contacts.append(made("contacts", Contact, table))
        coefficients[str(contacts[-1].name)] = _scatter("contacts.friction", friction)
    model = ContactModel(
        split_bodies(read_mesh(file.parent / str(tables["mesh"])), bodies),
        [_chosen("supports", _SUPPORTS, table) for table in tables.get("supports", [])],
        {
            case: [
                _chosen(f"loads.{case}", _LOADS, table)
                for table in (listed if isinstance(listed, list) else [listed])
            ]
            for case, listed in tables["loads"].items()
        },
        contacts,
        tables.get("kinematics"),
        ties=[made("ties", Tie, table) for table in tables.get("ties", [])],
    )
    return Joint(file.name, model, tables.get("thickness"), {}, coefficients, {})


def _chosen(where: str, kinds: Mapping[str, Any], table: Any) -> Any:
    """An instance of the class that a table names; a support without a name is a Support."""
    parts = list(table.values()) if isinstance(table, dict) else []
    if len(parts) == 1 and isinstance(parts[0], dict):
        ((name, arguments),) = table.items()
        name = known(where, name, kinds)
        return made(f"{where}: {name}", kinds[name], arguments)
    if kinds is _LOADS:
        raise ModelError(f"{where}: {table!r}; give the table of a load, {{ Pressure = {{...}} }}")
    return made(where, Support, table)


def _scatters(name: str, values: Mapping[str, Any]) -> dict[str, Any]:
    return {part: _scatter(f"{name}.{part}", value) for part, value in values.items()}


def _scatter(name: str, value: Any) -> Any:
    """A number, a range as tuple, or the distribution of a table."""
    if isinstance(value, dict):
        parameters = dict(value)
        return named_distribution(name, parameters.pop("distribution", None), **parameters)
    return tuple(value) if isinstance(value, list) else value
