"""A commander's diagnosis names the subordinates that are silent."""

from hitab_ros.diagnostics import Level

KIND = """\
commander: Squad
deadline: 1.5
orders:
  Attack: Search
"""


def test_silent_subordinates_are_named(team):
    chief = team.commander("chief", KIND, ["a", "b"])
    team.until(lambda: (Level.STALE, "silent subordinates: a, b") in chief.troubles())
    team.ant("a", "chief")
    team.until(lambda: (Level.WARN, "silent subordinates: b") in chief.troubles())
    team.ant("b", "chief")
    team.until(lambda: not chief.troubles())
    team.end("a")
    team.until(lambda: (Level.WARN, "silent subordinates: a") in chief.troubles())
    assert chief.diagnose().level == Level.WARN
