"""What a run has written, read: tables, frames, run.json. The standard library reads a series; arrays need numpy, frames h5py."""
