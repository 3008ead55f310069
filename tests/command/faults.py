"""Planted faults of `command`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "command/answers.py",
        "nan is an answer",
        old="isinstance(main, float) and math.isnan(main)",
        new="False",
        tests="command_questions",
        within="is_missing",
    ),
    Fault(
        "command/answers.py",
        "a table without rows loses the numbers of its answer",
        old="not len(table)",
        new="False",
        tests="command_questions",
        within="with_numbers",
    ),
    Fault(
        "command/options.py",
        "a flag of a true default does nothing",
        old="not default",
        new="default",
        tests="command_questions",
    ),
    Fault(
        "command/options.py",
        "options without a default are not required",
        old="default is inspect.Parameter.empty and not shared",
        new="False",
        tests="command_questions",
    ),
    Fault(
        "command/options.py",
        "texts that refer to another function are left as they are",
        old="name in there",
        new="False",
        tests="command_questions",
    ),
    Fault(
        "command/inputs.py",
        "units of the file give way to those of the command",
        old="system.units is not None",
        new="False",
        tests="command_questions",
    ),
    Fault(
        "command/questions.py",
        "options of another kind are dropped in silence",
        old="name not in ours",
        new="False",
        tests="command_questions",
    ),
    Fault(
        "command/questions.py",
        "the table of nodes lacks slip and open nodes",
        old="nodes.join(more[[name for name in more if name not in nodes]])",
        new="nodes",
        tests="command_questions",
    ),
    Fault(
        "command/studies.py",
        "an interrupted study counts no run as missing",
        old="len(table) + table.attrs['missing']",
        new="len(table)",
        tests="command_questions",
    ),
    Fault(
        "command/studies.py",
        "a study of which some runs fail is an answer",
        old="failed.empty",
        new="len(failed) < len(table)",
        tests="command_questions",
    ),
    Fault(
        "command/main.py",
        "errors are no JSON",
        old="getattr(options, 'json', False)",
        new="False",
        tests="command_questions",
    ),
    Fault(
        "command/questions.py",
        "a report has no range of frictions",
        old="add_friction(command, scatters=is_report)",
        new="add_friction(command, scatters=False)",
        tests="command_questions::test_a_report_has_a_range_of_frictions",
    ),
)
