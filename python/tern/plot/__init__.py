"""Pictures of runs (numpy, matplotlib, h5py): fields, gauges, energies, steps."""
