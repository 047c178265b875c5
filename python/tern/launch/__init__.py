"""The launcher behind ./tern: packages, build, processes of a run, verification. Standard library only."""
