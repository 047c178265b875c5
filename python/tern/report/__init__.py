"""Reports: one HTML page of runs, studies and maps, everything inline, readable without a network."""
