"""./tern verify: the results of a run held to the quantities of expected.toml."""
