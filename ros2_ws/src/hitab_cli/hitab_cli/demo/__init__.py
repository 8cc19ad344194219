"""The demo of a domain, which `hitab demo` runs."""
