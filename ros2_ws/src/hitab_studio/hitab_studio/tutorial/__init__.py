"""The tutorial inside the page: its steps, and where a person is in them."""
