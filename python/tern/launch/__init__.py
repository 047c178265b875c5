"""A run from a case to its results: packages, build, the processes and why they ended. Standard library only."""
