"""A build without ranks has no MPI in it, and nothing but ranks/mpi knows MPI.

Seen red: with the room ranks made from ranks/mpi in the default build; with mpi.h included in fluid/domain.cpp.
"""

import os
import re
import subprocess
import unittest
from pathlib import Path

BUILD, SOURCE = Path(os.environ["TERN_BUILD"]), Path(os.environ["TERN_SOURCE"])
ROOMS = "base sph scene run proto meeting ranks fluid structure coupler fixtures".split()


class Build(unittest.TestCase):
    def test_links_no_mpi(self):
        for name in ("tern-fluid", "tern-structure", "tern-coupler"):
            if not (BUILD / name).exists():
                self.skipTest(f"{name} is not built")
            libraries = subprocess.run(["ldd", BUILD / name], stdout=subprocess.PIPE, text=True, check=True).stdout
            self.assertEqual([line for line in libraries.splitlines() if re.search("(?i)libmpi|openmpi|petsc|zoltan", line)], [])

    def test_has_no_call_of_mpi(self):
        symbols = subprocess.run(["nm", "--dynamic", BUILD / "tern-fluid"], stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertEqual([line for line in symbols.splitlines() if "MPI_" in line], [])


class Source(unittest.TestCase):
    def test_has_mpi_in_one_place(self):
        speaks = re.compile(r"\bMPI_[A-Z]|<mpi\.h>")
        files = [file for room in ROOMS for file in (SOURCE / room).rglob("*.?pp")]
        self.assertGreater(len(files), 100)
        self.assertEqual([str(file.relative_to(SOURCE)) for file in files if speaks.search(file.read_text(encoding="utf-8"))],
                         ["ranks/mpi/ranks.cpp"])


if __name__ == "__main__":
    unittest.main()
