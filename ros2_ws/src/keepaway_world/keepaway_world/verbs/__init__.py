"""The verbs of keepaway: `hitab demo` and those under `hitab keepaway`."""
