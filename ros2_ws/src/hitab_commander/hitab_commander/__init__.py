"""The commander node: an agent whose basic behaviors are orders to its subordinates.

What a kind of commander can order and perceive is a `CommanderKind`, read from YAML
(`kind_reader`). `commander_domain` makes a domain of it, whose body (`commander_body`) is a group
of subordinates. `commander_node` puts it on topics.
"""
