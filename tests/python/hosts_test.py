#!/usr/bin/python3 -B
"""The file of the machines of a fluid in many processes, and what is refused of it, by name. Another machine is a script.

Seen red: with each refusal of hosts.py taken out, the test of its name.
"""

import os
import socket
import tempfile
import unittest
from pathlib import Path

from tern.errors import BAD_INPUT, Error
from tern.launch import hosts

AGENT = """#!/bin/sh
# ssh HOST COMMAND
shift
{preparation}
exec sh -c "$*"
"""


class HostsTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.path = Path(directory.name)
        self.before = os.environ.get(hosts.AGENT)
        self.addCleanup(self.restore)
        (self.path / "bin").mkdir()
        (self.path / "bin" / "orted").write_text("#!/bin/sh\n", encoding="utf-8")
        (self.path / "bin" / "orted").chmod(0o755)
        self.program = self.path / "tern-fluid"
        self.program.write_text("the program", encoding="utf-8")

    def restore(self):
        os.environ.pop(hosts.AGENT, None)
        if self.before is not None:
            os.environ[hosts.AGENT] = self.before

    def file(self, text):
        path = self.path / "hosts"
        path.write_text(text, encoding="utf-8")
        return path

    def read(self, text, interface="lo", ports=None, count=4, oversubscribe=False):
        return hosts.read(self.file(text), interface, ports, count, oversubscribe)

    def refused(self, asked):
        with self.assertRaises(Error) as refusal:
            asked()
        self.assertEqual(refusal.exception.exit_code, BAD_INPUT)
        return str(refusal.exception)

    def other_machine(self, preparation=""):
        """Every other machine is this script; it has an orted."""
        agent = self.path / "agent"
        agent.write_text(AGENT.format(preparation=f'PATH="{self.path}/bin:$PATH"; {preparation}'), encoding="utf-8")
        agent.chmod(0o755)
        os.environ[hosts.AGENT] = str(agent)

    def examined(self, interface="lo", files=None):
        machines = self.read("localhost slots=2\nnode2 slots=2\n", interface)
        return hosts.examine(machines, files or [self.program])


class File(HostsTest):
    def test_a_line_is_a_machine_and_the_ranks_it_takes(self):
        found = self.read(f"# ours\n{socket.gethostname()} slots=2  # this one\n\nnode2 slots = 6\n", "ib0", "20000-20006", 8)
        self.assertEqual([(host.name, host.slots) for host in found.machines], [(socket.gethostname(), 2), ("node2", 6)])
        self.assertEqual([host.name for host in found.others], ["node2"])
        words = found.options(self.path / "list")
        for name, value in (("btl_tcp_if_include", "ib0"), ("btl_tcp_port_min_v4", "20000"),
                            ("btl_tcp_port_range_v4", "7")):
            self.assertEqual(words[words.index(name) + 1], value)
        self.assertIn("2 on", found.sentence(8))
        self.assertIn("6 on node2", found.sentence(8))
        self.assertIn("ib0, ports 20000 to 20006", found.sentence(8))

    def test_a_line_that_is_none_is_named_by_its_number(self):
        self.assertIn("line 2: 'node2'", self.refused(lambda: self.read("localhost slots=2\nnode2\n")))
        self.assertIn("line 2: 'node2 slots=0'", self.refused(lambda: self.read("localhost slots=2\nnode2 slots=0\n")))
        self.assertIn("named twice", self.refused(lambda: self.read("localhost slots=2\nlocalhost slots=2\n")))
        self.assertIn("names no machine", self.refused(lambda: self.read("# nothing\n")))
        self.assertIn("cannot be read", self.refused(lambda: hosts.read(self.path / "missing", "lo", None, 1, False)))

    def test_the_first_rank_is_here(self):
        self.assertIn("begins with node2", self.refused(lambda: self.read("node2 slots=2\nlocalhost slots=2\n")))

    def test_more_ranks_than_the_machines_take(self):
        self.assertIn("take 3", self.refused(lambda: self.read("localhost slots=1\nnode2 slots=2\n")))
        self.assertTrue(self.read("localhost slots=1\nnode2 slots=2\n", oversubscribe=True))

    def test_a_network_is_named_unless_all_is_here(self):
        self.assertIn("--interface", self.refused(lambda: self.read("localhost slots=2\nnode2 slots=2\n", None)))
        self.assertEqual(self.read("localhost slots=4\n", None).network, "lo")
        self.assertEqual(self.read("localhost slots=4\n", "10.1.0.0/16").network, "10.1.0.0/16")
        for wrong in ("10.1.0.0/33", "10.1.0.1/16", "a b", "ib0,lo", "::1"):
            self.assertIn("neither", self.refused(lambda wrong=wrong: self.read("localhost slots=4\n", wrong)))

    def test_ports_are_a_range_that_suffices(self):
        for wrong in ("20000", "20-30", "20010-20000", "20000-70000"):
            self.assertIn("not a range", self.refused(lambda wrong=wrong: self.read("localhost slots=4\n", "lo", wrong)))
        self.assertIn("needs 5", self.refused(lambda: self.read("localhost slots=4\n", "lo", "20000-20003")))


class OtherMachines(HostsTest):
    def test_one_that_has_all_is_taken(self):
        self.other_machine()
        self.examined()
        self.examined("127.0.0.0/8")

    def test_one_that_is_not_reached(self):
        self.other_machine("echo 'Permission denied (publickey,password).' >&2; exit 255")
        self.assertIn("node2 cannot be reached by", said := self.refused(self.examined))
        self.assertIn("Permission denied (publickey,password).", said)

    def test_there_is_no_program_to_reach_it(self):
        os.environ[hosts.AGENT] = "/no/such/ssh"
        self.assertIn("there is no /no/such/ssh", self.refused(self.examined))

    def test_one_without_open_mpi(self):
        self.other_machine("PATH=/nowhere; exec /bin/sh -c \"$*\"")
        self.assertIn("node2 has no Open MPI", self.refused(self.examined))

    def test_one_without_the_network(self):
        self.other_machine()
        for network in ("ib77", "10.99.98.0/24"):
            self.assertIn(f"{network}: node2 has no such network", self.refused(lambda network=network: self.examined(network)))

    def test_this_one_without_the_network(self):
        """Seen red: with the others alone asked for it."""
        here = self.read("localhost slots=4\n", "ib77")
        self.assertIn("--interface ib77: this machine has no such network", self.refused(lambda: hosts.examine(here, [])))

    def test_a_number_of_ranks_that_no_machine_takes(self):
        self.assertIn("slots=K", self.refused(lambda: self.read("localhost slots=99999999999999999999\n", "lo")))

    def test_one_without_the_program_or_the_case(self):
        self.other_machine(f"mv '{self.program}' '{self.program}-away'")
        self.assertIn(f"node2 has no {self.program}", self.refused(self.examined))

    def test_one_with_another_program(self):
        away = self.path / "away"
        self.other_machine(f"echo other > '{away}'; sha256sum() {{ command sha256sum '{away}' | sed 's|{away}|{self.program}|'; }}; "
                           "eval \"$*\"; exit 0")
        self.assertIn("on node2 is another file than here", self.refused(self.examined))


if __name__ == "__main__":
    unittest.main()
