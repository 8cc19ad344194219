"""Times that several packages share, s, each with its reason.

A time that means one of these is not defined again elsewhere. `tests/test_architecture.py` limits
how many times there are.
"""

TURN_S = 0.01
"""Wait of a loop between two turns; shorter than a cycle of any shipped world."""

AT_ONCE_S = 0.05
"""Period of what a person must see at once; people notice delays from about 0.1 s."""

UPDATE_S = 0.1
"""Period of views, and of checks for what no event announces."""

REFRESH_S = 0.15
"""Period of what a page or a terminal shows; each update costs the server and the agent."""

STOP_REPORT_PERIOD_S = 0.1
"""Period of the signs of life of a robot's agent and relay; either acts when it misses a few."""

POLL_S = 0.25
"""Period of looks at the ROS graph, processes and files; each costs more than an event."""

HEARTBEAT_S = 0.5
"""Period of signs of life, and of checks that need not be more frequent than they are."""

REPEAT_S = 1.0
"""Time before something without an answer is tried again, and period of what nobody waits for."""

CONNECT_S = 0.7
"""Discovery time of a node that may not exist; those on one machine take less, even if busy."""

SETTLE_S = 1.5
"""Time without news after which the last is acted upon: nodes that start together, and what a
person shows, follow each other faster."""

SILENT_AFTER_S = 3 * HEARTBEAT_S
"""Silence of a node that gives signs of life; a network may lose one sign, or even two."""

PROMPT_S = 2.0
"""Timeout of a node that was discovered, for a first message or an acknowledgement; also what the
start of a process adds, since it takes at least a second of a core."""

FOUND_S = 3.0
"""Timeout to discover a node and receive its answer, if the node is up."""

DISCOVERY_S = 8.0
"""Discovery time of a node that should be up; usually less than 1 s, several on a busy machine."""

DISCOVERY_EACH_S = 0.02
"""Additional discovery time for each agent of a swarm, since all discover one another."""

LOOK_EACH_S = 0.002
"""Duration of a look at the ROS graph for each agent: looks are rarer in a large swarm."""

REMIND_S = 10.0
"""Time after which an error that lasts is logged or shown again; people read it once."""

ANSWER_S = 15.0
"""Timeout of an answer that takes work, such as a search; longer than any such work."""

START_S = 60.0
"""Timeout for a process to start on a busy machine; longer than any start that succeeded."""
