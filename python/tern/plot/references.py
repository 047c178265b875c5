"""The reference curves that the expected.toml of a case names."""

import functools
import tomllib
from pathlib import Path

from tern.results.tables import read_table


@functools.cache
def of(run):
    """{gauge column: [(label, t, value)]} of the CSV references of the run's case."""
    path = Path(run.contents.get("case_path", "")).parent / "expected.toml"
    if not path.is_file():
        return {}
    curves = {}
    for quantity in tomllib.loads(path.read_text(encoding="utf-8")).get("quantity", []):
        reference = path.parent / quantity.get("csv", "")
        if "csv" not in quantity or isinstance(quantity["column"], list) or not reference.is_file():
            continue
        entries = curves.setdefault(quantity["column"], {})
        table = read_table(reference)
        label = quantity["source"].split(",")[0].split(";")[0]
        entries[(reference, quantity["csv_column"])] = (label, table["t_s"], table[quantity["csv_column"]])
    return {column: list(entries.values()) for column, entries in curves.items()}
