"""A fluid in many processes whose coupler is over a network, or which is on many machines: results, and what listens where.

The other machine is a name of the host of its own, reached by a script in place of ssh; or a network namespace with a cable to this
one's, which needs root.

Seen red: with TERN_LISTEN_ON not set (what listens, for one machine and for two); with TERN_LISTEN_PORTS not set; with the network of
btl_tcp_if_include left out (namespaces); with ranks that do not compare their cases.
"""

import json
import os
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from network_run import NetworkRun, local_results, make_keys
from ranks_run import CASE, COARSE, OVERSUBSCRIBED, ROOT, RanksTest, alive, children_of, listeners, numbers_of, place

BITS = ROOT / "tests" / "process" / "cases" / "splash_plate"
AGENT = """#!/bin/sh
# ssh HOST COMMAND
host=$1; shift
export TMPDIR={directory}/tmp-$host
mkdir -p $TMPDIR
exec {inside} sh -c "hostname $host && $*"
"""
LOOPBACK = {"127.0.0.1", "::1"}
OWN_NAME = ["unshare", *(["--map-root-user"] if os.geteuid() else []), "--uts"]


def processes_of(directory):
    """{process id: name} of all whose command or environment names a directory: what Open MPI starts elsewhere is nobody's child."""
    found = {}
    for path in Path("/proc").glob("[0-9]*"):
        try:
            words = (path / "cmdline").read_bytes() + (path / "environ").read_bytes()
            if str(directory).encode() in words and alive(int(path.name)):
                found[int(path.name)] = (path / "comm").read_text(encoding="utf-8").strip()
        except OSError:
            continue
    return found


class HostsTest(RanksTest):
    def setUp(self):
        super().setUp()
        self.addCleanup(self.end)
        self.processes = []

    def end(self):
        for process in self.processes:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
            process.communicate(timeout=30)

    def popen(self, *words, **more):
        process = subprocess.Popen([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
        self.processes.append(process)
        return process

    def agent(self, inside):
        """The environment in which other machines are reached by a script; a file of two machines."""
        path = self.directory / "agent"
        path.write_text(AGENT.format(directory=self.directory, inside=" ".join(inside)), encoding="utf-8")
        path.chmod(0o755)
        (self.directory / "hosts").write_text("localhost slots=2\nnode2 slots=2\n", encoding="utf-8")
        return os.environ | {"OMPI_MCA_plm_rsh_agent": str(path)}

    def begun(self, name):
        steps = self.directory / name / "steps.csv"
        return steps.exists() and len(steps.read_text(encoding="utf-8").splitlines()) > 3

    def wait_for(self, process, name):
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and process.poll() is None and not self.begun(name):
            time.sleep(0.05)
        if not self.begun(name):
            process.send_signal(signal.SIGTERM)
            self.fail(process.communicate())


class Join(HostsTest):
    def test_ranks_join_a_coupler_over_the_network_and_open_nothing_to_it(self):
        until = ["--until", "0.1"]
        self.assertEqual(self.run_case("local", *until, "--ranks", "2", *OVERSUBSCRIBED, case=BITS), (0, ""))
        (self.directory / "keys").mkdir()
        make_keys(self.directory / "keys")
        with NetworkRun(self.directory, os.environ["TERN_BUILD"], BITS, until, self.directory / "keys") as run:
            port = run.start_coupler()
            run.join("fluid", f"tcp://127.0.0.1:{port}", "--ranks", "2", *OVERSUBSCRIBED)
            run.join("structure", f"tcp://127.0.0.1:{port}")
            self.assertTrue(run.wait_for_step(3), run.everything_said())
            found = listeners([pid for pid, _ in children_of(run.processes["fluid"].pid)])
            self.assertTrue(found)
            self.assertLessEqual({address for address, _ in found}, LOOPBACK)
            self.assertEqual(run.codes(120), {"coupler": 0, "fluid": 0, "structure": 0}, run.everything_said())
            self.assertNotIn("warning", run.said("fluid").replace("waits for", ""))
            results, local = run.results(), local_results(self.directory / "local")
            self.assertEqual([name for name in local if results.get(name) != local[name]], [])
            self.assertEqual(run.contents("fluid")["processes"]["fluid"]["counts"]["ranks"], 2)

    def test_a_private_run_opens_nothing_at_all(self):
        if subprocess.run(["unshare", "--map-root-user", "--net", "true"], check=False, capture_output=True).returncode != 0:
            self.skipTest("a network of its own is not allowed here")
        process = self.start("run", "--ranks", "2", *OVERSUBSCRIBED, "--set", "fluid.spacing=0.002")
        self.wait_for(process, "run")
        network = os.readlink("/proc/self/ns/net")
        shared = [pid for pid, _ in children_of(process.pid) if alive(pid) and os.readlink(f"/proc/{pid}/ns/net") == network]
        self.assertEqual(listeners([process.pid, *shared]), set())
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)

    def test_one_that_is_started_alone_meets_the_others_at_a_socket(self):
        where = ["--endpoint", f"ipc://{self.directory}/own.sock", "--until", "0.02"]
        parts = [self.start("run", *where, "--only", role, *words, case=BITS)
                 for role, words in (("coupler", []), ("fluid", ["--ranks", "2", *OVERSUBSCRIBED]), ("structure", []))]
        for part in parts:
            _, errors = part.communicate(timeout=120)
            self.assertEqual(part.returncode, 0, errors)


class Hosts(HostsTest):
    """Two machines of two ranks each, on the loopback network."""

    PORTS = (21300, 21320)

    def setUp(self):
        super().setUp()
        self.inside = OWN_NAME if subprocess.run([*OWN_NAME, "true"], check=False, capture_output=True).returncode == 0 else []

    def on_hosts(self, name, *words, case=CASE):
        environment = self.agent(self.inside)
        return self.popen(ROOT / "tern", "run", case, "--quiet", "--out", self.directory / name, "--ranks", "4", "--hosts",
                          self.directory / "hosts", "--interface", "lo", "--ports", "-".join(map(str, self.PORTS)), *OVERSUBSCRIBED,
                          *words, env=environment)

    def test_four_ranks_on_two_machines_have_the_bits_of_four_on_one(self):
        until = ["--until", "0.02", *COARSE]
        self.assertEqual(self.run_case("one", *until, "--ranks", "4", *OVERSUBSCRIBED), (0, ""))
        process = self.on_hosts("two", *until)
        _, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, errors)
        self.assertIn("2 on localhost, 2 on node2", errors)
        self.assertIn("at lo, ports 21300 to 21320", errors)
        self.assert_the_same_results("one", "two")

    def test_a_machine_on_which_nothing_starts_ends_the_run(self):
        environment = self.agent(self.inside)
        path = self.directory / "agent"
        path.write_text(path.read_text(encoding="utf-8").replace("mkdir", 'case "$*" in *hostname*) ;; *) exit 1 ;; esac\nmkdir'),
                        encoding="utf-8")
        answer = subprocess.run([ROOT / "tern", "run", CASE, "--quiet", "--out", self.directory / "run", "--ranks", "4", "--hosts",
                                 self.directory / "hosts", "--interface", "lo", *OVERSUBSCRIBED], capture_output=True, text=True,
                                env=environment, timeout=100, check=False)
        self.assertEqual(answer.returncode, 4, answer.stderr)
        self.assertIn("ORTE was unable to reliably start one or more daemons", answer.stderr)

    def test_nothing_listens_elsewhere_than_is_said(self):
        process = self.on_hosts("run", "--set", "fluid.spacing=0.002")
        self.wait_for(process, "run")
        first, last = self.PORTS
        found = listeners(processes_of(self.directory))
        self.assertLessEqual({address for address, _ in found}, LOOPBACK)
        used = [port for address, port in found if address == "127.0.0.1" and first <= port <= last]
        self.assertEqual(len(used), 6, found)  # two of Open MPI, and the ranks
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130)

    def test_a_killed_rank_of_another_machine_is_named_and_nothing_is_left(self):
        process = self.on_hosts("run", "--set", "fluid.spacing=0.002")
        self.wait_for(process, "run")
        ranks = numbers_of(pid for pid, name in processes_of(self.directory).items() if name == "tern-fluid")
        self.assertEqual(sorted(ranks), [0, 1, 2, 3])
        os.kill(ranks[3], signal.SIGKILL)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 4)
        machine = " on node2" if self.inside else ""
        self.assertIn(f"Rank 3 of tern-fluid{machine} was killed by signal 9", self.contents("run")["first_cause"])
        time.sleep(1)
        self.assertEqual(processes_of(self.directory), {})

    def test_a_file_of_the_case_that_differs_there_is_named(self):
        if subprocess.run([*OWN_NAME, "--mount", "true"], check=False, capture_output=True).returncode != 0:
            self.skipTest("another view of the files is not allowed here")
        for name, reach in (("motion.csv", 0), ("other.csv", 0.001)):
            (self.directory / name).write_text(f"t_s,x_m,y_m\n0,0,0\n10,{reach},0\n", encoding="utf-8")
        case = self.directory / "case.toml"
        case.write_text((CASE / "case.toml").read_text(encoding="utf-8").replace(
            'open = ["y_max"]', 'open = ["y_max"]\nmotion_file = "motion.csv"'), encoding="utf-8")
        self.inside = [*OWN_NAME, "--mount"]
        environment = self.agent(self.inside)
        path = self.directory / "agent"
        path.write_text(path.read_text(encoding="utf-8").replace("hostname $host", f"mount --bind {self.directory}/other.csv "
                                                                 f"{self.directory}/motion.csv && hostname $host"), encoding="utf-8")
        answer = subprocess.run([ROOT / "tern", "run", case, "--quiet", "--out", self.directory / "run", "--ranks", "4", "--hosts",
                                 self.directory / "hosts", "--interface", "lo", *OVERSUBSCRIBED], capture_output=True, text=True,
                                env=environment, timeout=100, check=False)
        self.assertEqual(answer.returncode, 2, answer.stderr)
        self.assertIn("Rank 2 on node2 has read another case than the first", self.contents("run")["first_cause"])

    def test_it_goes_on_where_it_was(self):
        process = self.on_hosts("two", "--until", "0.02", *COARSE, "--set", "output.checkpoint_interval=0.01")
        process.communicate(timeout=120)
        again = subprocess.run([ROOT / "tern", "resume", self.directory / "two", "--until", "0.03"], capture_output=True, text=True,
                               env=self.agent(self.inside), timeout=120, check=False)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("2 on node2", again.stderr)
        launch = json.loads((self.directory / "two" / "run.json").read_text(encoding="utf-8"))["launch"]
        self.assertEqual((launch["ranks"], launch["interface"]), (4, "lo"))


class Namespaces(HostsTest):
    """Two network namespaces with two cables: one between the machines that is named, one that is not."""

    NETWORK, OTHER, PORTS = "10.214.1.", "10.214.2.", (21400, 21402)

    def setUp(self):
        super().setUp()
        if os.geteuid() != 0 or shutil.which("ip") is None:
            self.skipTest("network namespaces need root and the program ip (Debian package iproute2)")
        self.names = [f"tern-{which}-{os.getpid()}" for which in ("one", "two")]
        self.addCleanup(lambda: [subprocess.run(["ip", "netns", "delete", name], capture_output=True, check=False) for name in self.names])
        one, two = self.names
        commands = [f"netns add {one}", f"netns add {two}"]
        for number, network in ((1, self.NETWORK), (2, self.OTHER)):
            commands += [f"-n {one} link add cable{number} type veth peer name cable{number} netns {two}"]
            for last, name in enumerate(self.names, 1):
                commands += [f"-n {name} address add {network}{last}/24 dev cable{number}", f"-n {name} link set cable{number} up"]
        commands += [f"-n {name} link set lo up" for name in self.names]
        for command in commands:
            answer = subprocess.run(["ip", *command.split()], capture_output=True, text=True, check=False)
            if answer.returncode != 0:
                self.skipTest(f"network namespaces may not be made here: {answer.stderr.strip()}")

    def test_two_machines_speak_over_the_network_that_is_named_and_listen_there_alone(self):
        one, two = self.names
        self.assertEqual(self.run_case("one", "--until", "0.6", *COARSE, "--ranks", "4", *OVERSUBSCRIBED), (0, ""))
        environment = self.agent(["ip", "netns", "exec", two, "unshare", "--uts"])
        process = self.popen("ip", "netns", "exec", one, ROOT / "tern", "run", CASE, "--quiet", "--out", self.directory / "two",
                             "--until", "0.6", *COARSE, "--ranks", "4", "--hosts", self.directory / "hosts", "--interface",
                             self.NETWORK + "0/24", "--ports", "21400-21404", *OVERSUBSCRIBED, env=environment)
        self.wait_for(process, "two")
        for last, name in enumerate(self.names, 1):
            table = subprocess.run(["ip", "netns", "exec", name, "cat", "/proc/net/tcp", "/proc/net/tcp6"], capture_output=True, text=True,
                                   check=True).stdout
            rows = [line.split()[1].split(":") for line in table.splitlines() if " 0A " in line]
            found = {(place(address), int(port, 16)) for address, port in rows}
            self.assertEqual({address for address, _ in found} - LOOPBACK, {f"{self.NETWORK}{last}"}, found)
            ports = {port for address, port in found if address not in LOOPBACK}
            self.assertEqual(len(ports), 3, found)
            self.assertTrue(ports <= set(range(21400, 21405)), found)
        _, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, errors)
        self.assert_the_same_results("one", "two")


if __name__ == "__main__":
    unittest.main()
