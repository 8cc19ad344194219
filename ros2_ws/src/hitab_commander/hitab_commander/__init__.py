"""The commander node: an agent whose basic behaviors are orders to its subordinates.

The orders and features of a kind of commander are a `CommanderKind`, read from YAML by
`kind_reader`. `commander_domain` turns it into a domain, whose body (`commander_body`) is a group
of subordinates. `commander_node` connects it to topics.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
