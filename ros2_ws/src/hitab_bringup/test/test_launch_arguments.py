"""The launch file takes the same arguments for a swarm as `hitab up`."""

import ast
import inspect
from pathlib import Path

from hitab_bringup.swarm_files.swarm_options import described_swarm

LAUNCH = Path(__file__).parents[1] / "launch" / "swarm.launch.py"


def test_the_launch_file_declares_and_passes_on_all_that_describes_a_swarm():
    tree = ast.parse(LAUNCH.read_text())
    options = set(inspect.signature(described_swarm).parameters)
    (declared,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "ARGUMENTS"
    )
    (call,) = (
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "described_swarm"
    )
    assert {
        name
        for name, *_ in ast.literal_eval(
            ast.unparse(declared).replace("SWITCH", "None").replace("*PACES", "")
        )
    } == options
    assert {keyword.arg for keyword in call.keywords} == options - {"swarm", "run_dir"}
