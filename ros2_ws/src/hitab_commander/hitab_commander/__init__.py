"""The commander node: an agent whose basic behaviors are orders to its subordinates."""
