"""The sections of `claims.md`: `python docs/claims.py` writes them anew.

The text of a sentence, and below it its assumption, are in `frictopt/limits`. The source and the
tests of the sentence are here, because no user needs them at run time. An assumption that several
sentences share is here, too. To add a sentence, write it with its assumption in `frictopt/limits`,
give it a claim in this file, and run this file.
`tests/repository/test_claims.py` fails for a sentence without a claim, assumption or test.
"""

import ast
import inspect
import re
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from pathlib import Path

from frictopt.limits.answers import sentences

PAGE = Path(__file__).with_name("claims.md")


@dataclass(frozen=True)
class Claim:
    """A section of the page.

    `sentences` are names `room.file.NAME` of sentences in `frictopt/limits`. `also` has the words
    with which attributes, pages and errors claim the same. `by` names the result whose reason has
    the sentences, and then other places that claim the same. If `holds_if` is empty, the section
    has the assumptions of its sentences. A section with the default `source` does not name its
    source, because the head of the page describes it.
    """

    sentences: str
    by: str
    tests: str
    source: str = "multipliers"
    holds_if: str = ""
    also: str = ""

    @property
    def texts(self) -> list[str]:
        """The sentences, with dots in place of values."""
        return [shortened(text_of(name)) for name in self.sentences.split()]

    def section(self, number: int) -> str:
        """The section: its sentences as a quotation, and below them conditions, source and tests."""
        said = [sentence.strip(" ;") for sentence in (*self.texts, self.also) if sentence]
        assumed = [ASSUMED.get(name, "") for name in self.sentences.split()]
        first, _, others = self.by.partition(", ")
        items = {
            "Also said by": others,
            "Holds if": self.holds_if or "; ".join(dict.fromkeys(filter(None, assumed))),
            "Source": "" if self.source == "multipliers" else self.source,
            "Test": ", ".join(f"`{test}`" for test in self.tests.split()),
        }
        if not (said and items["Holds if"] and items["Test"]):
            raise ValueError(f"{self.sentences}{self.also}: something is empty in {items}")
        quotation = "\n>\n".join(f"> {sentence}" for sentence in said)
        below = "\n".join(f"- {name}: {text}" for name, text in items.items() if text)
        return f"## {number}. {first}\n\n{quotation}\n\n{below}\n"


def assumptions() -> dict[str, str]:
    """Name -> assumption of each sentence of `sentences.py`: the string below the sentence."""
    found = {}
    for assigned, text in pairwise(ast.parse(inspect.getsource(sentences)).body):
        if isinstance(assigned, ast.Assign) and isinstance(text, ast.Expr):
            assumption = " ".join(ast.literal_eval(text.value).split())
            name = f"answers.sentences.{ast.unparse(assigned.targets[0])}"
            found[name] = assumption.removeprefix("Assumption: ").removesuffix(".")
    return found


ASSUMED = assumptions()


def text_of(name: str) -> str:
    """The text of a sentence with a name `room.file.NAME` in `frictopt/limits`."""
    file, constant = name.rsplit(".", 1)
    return str(getattr(import_module(f"frictopt.limits.{file}"), constant))


def shortened(text: str) -> str:
    """A text with dots in place of its values."""
    text = text.replace("{slip}", "residual slip")
    return re.sub(r"(\{[^{}]*\})+", "…", text).strip(" ;:,")


CLAIMS = (
    Claim(
        "answers.sentences.HIGHEST",
        by="`ShakedownLimit`, README, index, checked, theory, glossary, validity",
        holds_if="at every load corner the nodes of `limit.open` are open and all other nodes closed; if `limit.events` lists nodes, these nodes open and close in its order",
        source='multipliers (theory, eq. (8); "Nodes that open and close in each cycle")',
        tests="test_claims::test_a_closed_contact_rests_above_its_bound_with_nodes_that_open_and_close test_claims::test_with_other_nodes_open_a_contact_rests_above_its_bound test_lift_off::test_a_pin_rests_though_its_sides_lift_off_in_each_cycle",
        also='`bound`; "from both sides"',
    ),
    Claim(
        "answers.sentences.BETWEEN answers.sentences.STOPPED_WIDE",
        by="`ShakedownLimit`, theory, size",
        source='the contact law for the lower number, multipliers for the upper one (theory, "A limit between two proven numbers")',
        tests="test_within_gap::test_both_numbers_are_proven_by_hand_in_the_plane test_within_gap::test_the_exact_limit_in_space_lies_between_both_numbers test_within_gap::test_a_gap_below_single_precision_is_not_reached_and_says_so",
    ),
    Claim(
        "answers.sentences.REQUIRED_BETWEEN",
        by="`RequiredFriction`",
        source='the contact law for the upper number, multipliers for the lower one (theory, "A limit between two proven numbers")',
        tests="test_friction_within_gap::test_both_frictions_are_proven_by_hand_in_the_plane test_friction_within_gap::test_the_exact_friction_in_space_lies_between_both",
    ),
    Claim(
        "answers.sentences.NO_BOUND",
        by="`ShakedownLimit`",
        source="the contact law, checked in each run",
        tests="test_moving_events::test_a_cylinder_of_two_materials",
        also="no states, because it is infinite: even … the contact may shake down above the limit; `covers`",
    ),
    Claim(
        "answers.sentences.NO_EVENTS answers.sentences.CALL_WITH_EVENTS",
        by="`ShakedownLimit`",
        source='a search, and a lemma (theory, "Nodes that open and close in each cycle")',
        tests="test_moving_events::test_a_cylinder_of_two_very_different_materials_slips_under_its_pressure_alone test_moving_events::test_a_reason_says_where_to_ask_for_events",
    ),
    Claim(
        "",
        also="every history of one load between two ends, and the cycle of these ends, have the same limit with events; `least` is 0 if the mean load lies between them",
        by="`shakedown_limit`, theory",
        holds_if="all load corners lie on one line of loads",
        source='theorem (theory, "Nodes that open and close in each cycle")',
        tests="test_moving_events::test_turning_points_on_a_line_change_nothing",
    ),
    Claim(
        "answers.sentences.HIGHER_WITH_OTHERS_OPEN answers.sentences.BOUND_COVERS",
        by="`ShakedownLimit`",
        source="multipliers of this set of open nodes",
        tests="test_claims::test_with_other_nodes_open_a_contact_rests_above_its_bound test_own_constraints::test_constraints_that_nothing_obeys_are_named",
    ),
    Claim(
        "answers.sentences.STATIC",
        by="`ShakedownLimit`",
        holds_if="all load corners are the same load, all nodes are closed, and there are no user constraints",
        source="multipliers, and multipliers of `gross_slip`",
        tests="test_claims::test_under_a_static_load_a_contact_rests_above_its_bound",
    ),
    Claim(
        "",
        also="states of rest with … all through the cycle; with other nodes open, or nodes that open and close, the contact may shake down above it; states of rest with …; with other nodes, or in another order, the contact may shake down above it; `covers`",
        by="`ShakedownLimit`",
        holds_if="the nodes of `limit.open` stay open, and all other nodes stay closed",
        tests="test_set_search::test_a_node_that_the_corners_lift_rests_open_far_above_the_limit_which_no_search_near_it_finds",
    ),
    Claim(
        "answers.sentences.NOTHING_SAFE answers.sentences.NO_FRICTION answers.sentences.NO_PRESSURE",
        by="`ShakedownLimit`",
        holds_if="the same nodes are closed at all corners; if nodes open and close in each cycle, the contact may shake down",
        tests="test_claims::test_where_nothing_is_safe_nothing_is_proven_of_starts test_spatial_embedded::test_a_node_that_alone_keeps_the_limit_at_zero_is_named",
    ),
    Claim(
        "answers.sentences.CONTRADICTED",
        by="`ShakedownLimit`",
        tests="test_own_constraints::test_constraints_that_nothing_obeys_are_named",
    ),
    Claim(
        "answers.sentences.UNSAFE_BELOW",
        by="`ShakedownLimit`, `least` of `GuaranteedLimit` and `Design`",
        holds_if="the same nodes are closed at all corners; then, below this load factor, slip, opening or touching continues from every start",
        tests="test_least_load::test_two_uncoupled_nodes_by_hand",
        also="`least`",
    ),
    Claim(
        "answers.sentences.NOT_HIGHER_WITH_OTHERS_OPEN",
        by="`ShakedownLimit`, validity, faq, theory",
        holds_if="the closed nodes of a set keep its open nodes from moving freely; sets that are not safe at the limit do not count; if nodes open and close in each cycle, the contact may shake down above the limit",
        source='multipliers of each branch of the search (theory, "All sets")',
        tests="test_all_sets::test_no_set_of_a_small_contact_in_the_plane_is_better test_all_sets::test_limits_above_load_factors_that_are_not_safe_are_separate",
        also="`best_of_all`, `bound_of_sets`",
    ),
    Claim(
        "answers.sentences.START_UNKNOWN",
        by="`ShakedownLimit`",
        source="no proof",
        tests="test_least_load::test_where_rounding_hides_the_least_load_factor_the_limit_stands_and_says_so",
    ),
    Claim(
        "answers.sentences.INFINITE",
        by="`ShakedownLimit`",
        holds_if="always: each safe slip obeys the contact law, but it may be larger than assembly can leave",
        source='a safe slip, and a direction in which the load factor grows without bound (theory, "The arrays of a program")',
        tests="test_least_load::test_one_node_without_a_largest_load_factor",
    ),
    Claim(
        "answers.sentences.CHOSEN",
        by="`ShakedownLimit`",
        tests="test_own_constraints::test_rows_equations_norms_and_objectives_of_slip_load_factor_and_reactions",
    ),
    Claim(
        "answers.sentences.ONLY_SLIP_PRESSES",
        by="`ShakedownLimit`",
        source="the sign of the normal force of this node under the mean load without slip",
        tests="test_limit_kinds::test_a_node_that_only_slip_presses_is_named",
    ),
    Claim(
        "answers.sentences.BELONGS_TO_MESH",
        by="`ShakedownLimit`, `GuaranteedLimit`",
        source="observed on meshes of smooth contacts",
        tests="test_walking::test_the_limit_of_a_cylinder_under_constant_pressure_falls_with_the_mesh_to_zero",
    ),
    Claim(
        "",
        also="a lower bound of slip and gaps in every cycle, from every start",
        by="`LeastSlip`, `least_slip`, theory",
        holds_if="open nodes carry no force; for `total`, which counts slip alone, all nodes stay closed",
        source="multipliers (theory, eq. (20))",
        tests="test_open_nodes::test_every_cycle_above_the_limit_slips_as_much_as_is_proven_while_the_open_nodes_carry_nothing",
    ),
    Claim(
        "answers.sentences.SLIP_IS_SAFE answers.sentences.SLIP_WITH_EVENTS",
        by="`SafeSlip`",
        source="the contact law, checked in each run",
        tests="test_lift_off_questions::test_a_pin_has_the_safe_slip_of_a_plain_program_and_rests_with_it",
    ),
    Claim(
        "answers.sentences.NO_SLIP_IS_SAFE answers.sentences.NOR_WITH_SOME_OPEN",
        by="`SafeSlip`",
        tests="test_claims::test_under_a_static_load_a_contact_rests_above_its_bound",
    ),
    Claim(
        "answers.sentences.LESS_IS_NOT_SAFE required_friction._UNDECIDED",
        by="`RequiredFriction`",
        tests="test_required_friction::test_it_is_proven_from_both_sides",
        also='"from both sides"',
    ),
    Claim(
        "answers.sentences.NONE_NEEDED",
        by="`RequiredFriction`",
        source="the contact law, checked in each run",
        tests="test_required_friction::test_where_no_friction_is_needed",
    ),
    Claim(
        "answers.sentences.ENOUGH_WITH_EVENTS",
        by="`RequiredFriction`",
        source="the contact law for `slip`, checked in each run; the search for less friction",
        tests="test_lift_off_questions::test_required_friction_agrees_with_the_limit_from_both_sides",
    ),
    Claim(
        "answers.sentences.NOT_FROM_EVERY_START",
        by="`RequiredFriction`",
        source="transients",
        tests="test_required_friction::test_as_assembled_a_joint_slips_with_more_friction_than_it_needs",
    ),
    Claim(
        "answers.sentences.NONE_IS_ENOUGH answers.sentences.LOADS_OPEN",
        by="`RequiredFriction`",
        tests="test_required_friction::test_less_friction_is_enough_with_the_node_that_it_leaves_open",
    ),
    Claim(
        "answers.sentences.SIDES answers.sentences.GAP_OF_SIDES answers.sentences.NO_AMPLITUDES answers.sentences.NO_AMPLITUDES_ABOVE_ZERO answers.sentences.ALL_AMPLITUDES answers.sentences.ONE_UNLIMITED",
        by="`SafeRegion`",
        tests="test_open_nodes::test_amplitudes_of_two_loads_with_a_node_that_stays_open",
    ),
    Claim(
        "answers.sentences.BEST_DESIGN answers.sentences.OTHER_DESIGNS_OPEN",
        by="`Design`",
        tests="test_design_opens::test_the_best_design_of_random_contacts_is_that_of_its_open_nodes",
    ),
    Claim(
        "answers.sentences.NO_OTHER_DESIGNS_OPEN",
        by="`Design`",
        holds_if="the closed nodes of a set keep its open nodes from moving freely; each node stays open or stays closed all through the cycle",
        source='multipliers of each branch of the search (theory, "All sets")',
        tests="test_design_opens::test_a_relaxed_constraint_never_lowers_a_design",
    ),
    Claim(
        "answers.sentences.BEST_SAFE_DESIGN",
        by="`Design`",
        tests="test_design_mean_load::test_random_designs_are_safe_under_the_mean_load_if_any_is",
    ),
    Claim(
        "",
        also="no design is safe at any load factor with all nodes closed; no design is safe at any load factor above 0 with all nodes closed",
        by="`DesignModel`",
        holds_if="all nodes are closed",
        tests="test_design_refused::test_designs_that_cannot_be_name_the_constraints_that_contradict",
    ),
    Claim(
        "answers.sentences.CRITICAL answers.sentences.BOTH_BOUNDS answers.sentences.BOUNDS_IN_SPACE answers.sentences.AT_EVERY_LOAD answers.sentences.UNLOADED",
        by="`GuaranteedLimit`",
        holds_if="always: the slip of the answer brings this node to these bounds",
        source="the contact law, checked in each run",
        tests="test_limit_kinds::test_the_reason_of_a_witness_names_node_and_corners test_limit_kinds::test_a_node_that_slip_unloads_is_named",
    ),
    Claim(
        "answers.sentences.WEDGED",
        by="`GuaranteedLimit`",
        source="the stiffness of this node alone (Klarbring 1990)",
        tests="test_limit_kinds::test_a_node_that_may_wedge_itself_is_named",
    ),
    Claim(
        "answers.sentences.ONLY_AT_LEAST",
        by="`GuaranteedLimit`",
        tests="test_guaranteed_zero::test_where_loads_press_the_node_more_than_they_shear_it_is_no_witness",
    ),
    Claim(
        "",
        also='lambda_1 is lambda_2, because the contact is uncoupled (B = 0); `proven`; "a theorem"; "from every start"; "shakedown is certain"',
        by="`GuaranteedLimit`, `GuaranteedModel`, `guaranteed_limit`, api/limits, theory, validity, glossary, faq, tutorial/punch",
        holds_if="B is zero for all nodes up to rounding",
        source="Klarbring, Ciavarella & Barber (2007); its proof also holds with open nodes, because they carry no force",
        tests="test_claims::test_a_proven_guaranteed_limit_holds_from_starts_that_open_and_close_nodes",
    ),
    Claim(
        "",
        also="the sentences of the last section are not used if only the closed nodes are uncoupled, or if f B = 0 but B is not zero",
        by="`GuaranteedLimit`",
        holds_if="always: a start may close an open node, or open a node without friction, which then couples other nodes",
        source="transients",
        tests="test_claims::test_a_guaranteed_limit_is_not_proven_where_the_closed_nodes_alone_are_uncoupled test_claims::test_a_node_without_friction_couples_the_others_once_a_start_opens_it",
    ),
    Claim(
        "",
        also="need no program: lambda_1 is lambda_2, because the contact is uncoupled (B = 0) or no load factors lie between the two",
        by="`record.left_out`",
        holds_if="B is zero for all nodes, and all nodes are closed",
        source="Klarbring, Ciavarella & Barber (2007)",
        tests="test_claims::test_without_any_friction_a_contact_is_uncoupled_only_where_it_is",
    ),
    Claim(
        "answers.sentences.SAME_LIMIT",
        also="lambda_1 is lambda_2, because no node is critical below it; the nodes that need no program cannot be critical below the limit, by a lower bound, or can only lift off when critical, or have no friction",
        by="`GuaranteedLimit`",
        holds_if="the sentences concern critical nodes only; that no start slips for ever below the limit is an observation",
        tests="test_guaranteed::test_any_cycle_against_linear_programs_of_all_corners",
    ),
    Claim(
        "answers.sentences.LIFTING",
        by="`GuaranteedLimit`",
        source="transients from some starts do slip for ever",
        tests="test_open_nodes::test_starts_from_which_nodes_open_and_close_slip_for_ever_below_a_guaranteed_limit",
    ),
    Claim(
        "",
        also="the depths that wear off in the end; `proven`",
        by="`worn_in`, `WornIn`, validity",
        holds_if="B = 0, A = alpha C, one coefficient of friction, and loads on a line; other contacts are refused",
        source="theory, eq. of the worn-in profile",
        tests="test_worn_in::test_simulated_wear_ends_there",
    ),
    Claim(
        "",
        also="damping is zero from every start below the guaranteed limit, and from no start above the shakedown limit",
        by="`BackboneCurve`, `backbone_curve`, theory",
        holds_if="nodes stay closed and have friction; below the guaranteed limit it is a theorem only if `proven` is true",
        source="the sentences about both limits",
        tests="test_backbone::test_damping_below_the_guaranteed_limit_where_a_node_opens_and_closes",
    ),
    Claim(
        "answers.sentences.ABOVE answers.sentences.BELOW answers.sentences.NO_STATE answers.sentences.APART answers.sentences.UNBALANCED",
        by="`GrossSlip`, `bound_for_all` and `proven` of `ShakedownLimit`, theory",
        source="a rigid motion in which contact forces do no negative work (theory, eq. (33))",
        tests="test_gross_slip::test_only_the_rigid_motions_of_a_stiffness_count_and_no_gap_does test_gross_slip::test_limits_of_all_states_and_of_some",
        also="`bound`",
    ),
    Claim(
        "answers.sentences.HELD",
        by="`GrossSlip`",
        source="the rigid motions of the stiffness",
        tests="test_gross_slip::test_held_bodies_never_slide_off",
    ),
    Claim(
        "answers.sentences.ALL_BALANCED",
        by="`GrossSlip`",
        source="forces that balance the loads, and a direction in which the load factor grows without bound",
        tests="test_gross_slip::test_random_faces_in_the_plane_agree_with_scipy",
    ),
    Claim(
        "answers.sentences.SLIDES_OFF_ABOVE answers.sentences.SLIDES_OFF_AT_ANY answers.sentences.SELF_STRESSED answers.sentences.STOPPED answers.sentences.GOES_ON",
        by="`GrossSlip`, theory",
        source="transients from no slip",
        tests="test_gross_slip::test_a_press_fit_slides_off_at_friction_times_the_pressure_of_the_fit",
    ),
    Claim(
        "answers.sentences.MOVES",
        by="`ShakedownLimit`, theory, validity, faq, tutorial/which",
        holds_if="B = 0 up to rounding; the load factor scales shear alone; all nodes have friction; no slip bound, user constraints or `open_nodes`",
        source='theorem (theory, "Contact areas that move"), and multipliers',
        tests="test_moving_areas::test_random_contacts_rest_just_below_and_slip_just_above_from_every_start",
        also="all states of rest, for all openings and closings; `covers`, `bound_for_all`, `proven`",
    ),
    Claim(
        "answers.sentences.SLIPS_AT_ANY answers.sentences.SLIPS_BUT_AT_ONE answers.sentences.CLOSES_OTHERWISE",
        by="`ShakedownLimit`",
        holds_if="B = 0, and the load factor scales shear alone; the best solution of the equations of the rim leaves more than 1e-9 of the cyclic shear",
        source="theorem (theory, eq. of the rim), and least squares",
        tests="test_moving_areas::test_a_phase_leaves_no_limit_and_its_transients_slip test_moving_areas::test_held_shear_that_differs_leaves_all_load_factors_or_one_or_none",
    ),
    Claim(
        "answers.sentences.FROM_EVERY_START",
        by="`ShakedownLimit`",
        holds_if="B = 0, the load factor scales shear alone, and supports hold the bodies",
        source="theorem (theory, uncoupled contacts that lift off)",
        tests="test_moving_areas::test_random_contacts_rest_just_below_and_slip_just_above_from_every_start",
    ),
    Claim(
        "answers.sentences.NO_STATE_OF_REST answers.sentences.TOO_LITTLE_PRESSURE",
        by="`ShakedownLimit`",
        holds_if="B = 0, and the load factor scales shear alone; no slip is safe in the program of all states of rest",
        tests="test_moving_areas::test_held_shear_that_differs_leaves_all_load_factors_or_one_or_none",
    ),
    Claim(
        "answers.sentences.LAST_REST answers.sentences.IN_THIS_ORDER answers.sentences.IN_ANOTHER_ORDER answers.sentences.CLOSES_ABOVE answers.sentences.LIFTED_OFF",
        by="`ShakedownLimit`, theory, validity",
        holds_if="B = 0 up to rounding; all nodes have friction; the same fixed loads at all load corners; no slip bound, user constraints or `open_nodes`; no interval of load factors with one order of opening and closing is shorter than 1e-6 of the load factor plus its unit",
        source='theorem (theory, "Normal loads that are scaled, too"), and multipliers in each of these intervals',
        tests="test_rest_intervals::test_random_contacts_rest_inside_of_their_intervals_and_slip_outside test_rest_intervals::test_in_phase_a_cylinder_rests_up_to_gross_slip test_rest_intervals::test_with_a_phase_a_cylinder_slips_from_the_load_on_at_which_its_first_node_opens test_rest_intervals::test_a_body_that_lifts_off_ends_the_load_factors",
        also="states of rest just above it, for all openings and closings; `covers`, `intervals`",
    ),
    Claim(
        "answers.sentences.NO_REST_THERE answers.sentences.TOO_LITTLE_FRICTION answers.sentences.NONE_STOPS_IT",
        by="`SafeSlip`, `RequiredFriction`",
        source='theorem (theory, "Contact areas that move"), multipliers, and least squares',
        tests="test_moving_safe_slip::test_a_rolling_cylinder_has_a_safe_slip_up_to_its_limit test_moving_safe_slip::test_with_a_phase_no_friction_is_enough",
    ),
    Claim(
        "answers.sentences.OBSERVED",
        by="`GuaranteedLimit`",
        source="transients",
        tests="test_moving_areas::test_the_guaranteed_limit_is_the_same_number_and_proven_if_bodies_are_held",
    ),
    Claim(
        "",
        also="by a theorem: the load from equilibrium never falls with friction, and is a concave function of the preloads",
        by="`Report`, `report`, validity, tutorial/report",
        holds_if="no contact forces are in balance without loads; otherwise transients at the corners of the ranges are followed, and no theorem is claimed",
        source='forces within friction are a convex cone that grows with friction (validity, "Scatter")',
        tests="test_sheet::test_no_input_in_the_ranges_is_worse_against_gross_slip",
    ),
    Claim(
        "",
        also="the range of the work of friction over all starts; the steady state of each start",
        by="`dissipation_range`, `dissipation_study`",
        holds_if="found by a search, not proven: another start may dissipate more or less",
        source="transients",
        tests="test_dissipation_range::test_the_least_orbit_slips_as_little_as_is_proven",
    ),
    Claim(
        "",
        also="above the limit the contact slips in every cycle, whatever the start; below it not from every start",
        by="theory, README, index, faq, tutorial/spatial, tutorial/joint, tutorial/punch, tutorial/which, `python -m studies first_look`",
        holds_if="all nodes stay closed",
        tests="test_claims::test_a_closed_contact_rests_above_its_bound_with_nodes_that_open_and_close test_claims::test_front_pages_claim_no_more_than_the_answers test_claims::test_the_first_command_and_its_picture_claim_no_more_than_the_answers",
    ),
    Claim(
        "answers.sentences.BAND_OF_RESTS answers.sentences.OTHER_STARTS",
        by="`FatigueBand`, `FatigueLimit`, theory",
        source="multipliers for the least value, and for the largest if `proven`; both occur (theory, eq. (37))",
        tests="test_fatigue_band::test_no_vertex_of_the_safe_slips_is_outside_and_both_ends_occur test_fatigue_band::test_both_ends_are_attained_by_transients_that_start_with_their_slips",
    ),
    Claim(
        "answers.sentences.BAND_OF_CYCLES",
        by="`FatigueBand`, theory",
        source='one transient, and the theorem that steady cycles differ by a constant slip (theory, "The fatigue band")',
        tests="test_fatigue_band::test_above_the_limit_all_steady_cycles_of_an_uncoupled_contact_are_in_the_band",
    ),
    Claim(
        "answers.sentences.BAND_OF_FAMILY",
        by="`FatigueBand`, theory",
        source='one transient; the added slip does not change the forces of nodes that slip (theory, "The fatigue band")',
        tests="test_fatigue_band::test_cycles_that_a_slip_shifts_obey_the_law_and_both_ends_occur",
    ),
    Claim(
        "answers.sentences.ALLOWED answers.sentences.NOT_ALLOWED answers.sentences.RESTS_END",
        by="`FatigueLimit`, theory",
        holds_if="the stress map belongs to the contact, and nodes stay open or closed",
        source="multipliers if `proven`; a state of rest with the value occurs (theory, eq. (38))",
        tests="test_fatigue_limit::test_the_first_crossing_counts_if_the_worst_falls_again test_fatigue_limit::test_no_vertex_below_the_limit_has_more_and_one_above_has test_fatigue_limit::test_both_limits_of_crossland_are_linear_programs_in_load_factor_and_slip",
    ),
    Claim(
        "answers.sentences.WEDGES answers.sentences.GROWS_WITH_MESH",
        by="`FatigueBand`, theory",
        source='a program without loads; the stress of a shear that jumps (theory, "The fatigue band")',
        tests="test_fatigue_band::test_friction_that_wedges_leaves_no_worst_state test_fatigue_band::test_the_face_is_marked_and_a_depth_is_not",
    ),
)


def page(text: str) -> str:
    """The text of the page, in which all sections are made anew and the head is kept."""
    head = text.partition("## ")[0]
    return head + "\n".join(claim.section(number) for number, claim in enumerate(CLAIMS, start=1))


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
