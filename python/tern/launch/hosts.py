"""The machines of a fluid in many processes: a file that names them, what has to be so on each, and the network between them.

Open MPI has no keys. What it opens between machines is therefore limited to a network that the user names (ranks/listen/), and said.
"""

import hashlib
import ipaddress
import os
import re
import shlex
import shutil
import socket
import subprocess
from dataclasses import dataclass, replace
from pathlib import Path

from tern.errors import BAD_INPUT, Error

LINE = re.compile(r"(?P<name>[A-Za-z0-9][A-Za-z0-9._-]*)\s+slots\s*=\s*(?P<slots>[1-9][0-9]{0,5})")
ANSWER_S = 20  # of a machine that is asked what it has
AGENT = "OMPI_MCA_plm_rsh_agent"  # Open MPI's own variable for what reaches another machine in place of ssh


@dataclass(frozen=True)
class Host:
    """A line of the file."""

    name: str
    slots: int  # ranks it takes

    @property
    def is_here(self):
        return self.name in ("localhost", socket.gethostname(), socket.getfqdn())


@dataclass(frozen=True)
class Hosts:
    """Machines, and over what their ranks speak."""

    machines: tuple     # of Host
    network: str        # name of an interface, or as 10.1.0.0/16
    ports: tuple | None  # first and last

    @property
    def others(self):
        return [host for host in self.machines if not host.is_here]

    def write(self, path):
        path.write_text("".join(f"{host.name} slots={host.slots}\n" for host in self.machines), encoding="utf-8")

    def options(self, path):
        """Those of mpirun, for the file that write() has made."""
        words = ["--hostfile", str(path), "--mca", "plm_rsh_no_tree_spawn", "1", "--mca", "btl_tcp_if_include", self.network,
                 "--mca", "btl_tcp_disable_family", "6"]
        if AGENT not in os.environ:
            words += ["--mca", "plm_rsh_agent", "ssh -o BatchMode=yes"]
        if self.ports:  # of the ranks; mpirun would open all that it is given, ranks/listen/ gives it one
            first, last = self.ports
            words += ["--mca", "btl_tcp_port_min_v4", str(first), "--mca", "btl_tcp_port_range_v4", str(last - first + 1)]
        return words

    def sentence(self, count):
        """What listens where while the run lasts."""
        left, shares = count, []
        for host in self.machines:
            share = min(host.slots, left) if host is not self.machines[-1] else left
            left -= share
            shares.append(f"{share} on {host.name}")
        ports = f"ports {self.ports[0]} to {self.ports[1]}" if self.ports else "any free port (--ports limits them)"
        return (f"{count} ranks, {', '.join(shares)}. Open MPI listens on each machine at {self.network}, {ports}. It has no keys: who "
                "reaches these can read and disturb the run.")


def _refuse(text):
    raise Error(BAD_INPUT, text)


def _machines(path):
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        _refuse(f"--hosts {path} cannot be read: {error}.")
    machines = []
    for number, line in enumerate(lines, 1):
        line = line.partition("#")[0].strip()
        if not line:
            continue
        found = LINE.fullmatch(line)
        if not found:
            _refuse(f"{path}, line {number}: {line!r} does not name a machine; write NAME slots=K, with the number of ranks it takes.")
        if found["name"] in (host.name for host in machines):
            _refuse(f"{path}, line {number}: {found['name']} is named twice.")
        machines.append(Host(found["name"], int(found["slots"])))
    if not machines:
        _refuse(f"--hosts {path} names no machine.")
    return tuple(machines)


def _network(text):
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9._-]*", text):
        return text
    try:
        return str(ipaddress.IPv4Network(text))
    except ValueError:
        _refuse(f"--interface {text} is neither the name of a network interface nor a network as 10.1.0.0/16.")


def _ports(text):
    found = re.fullmatch(r"(\d+)-(\d+)", text)
    first, last = (int(part) for part in found.groups()) if found else (0, 0)
    if not 1024 <= first <= last <= 65535:
        _refuse(f"--ports {text} is not a range as 20000-20099, within 1024 to 65535.")
    return first, last


def read(path, interface, ports, count, oversubscribe):
    """The hosts of a run as asked for. Raises Error with what of it cannot be, as far as this machine knows."""
    machines = _machines(path)
    hosts = Hosts(machines, "lo", _ports(ports) if ports else None)
    if not machines[0].is_here:
        _refuse(f"--hosts {path} begins with {machines[0].name}, which is not this machine ({socket.gethostname()}, or localhost): the "
                "first rank writes the results and speaks with the coupler, so it has to be here.")
    slots = sum(host.slots for host in machines)
    if count > slots and not oversubscribe:
        _refuse(f"--ranks {count}: the machines of {path} take {slots}; give fewer, more slots, or --oversubscribe.")
    if hosts.others and interface is None:
        _refuse("--hosts needs --interface: the name of the network interface between the machines, or their network as 10.1.0.0/16. "
                "Open MPI has no keys, and listens there only.")
    most = count if oversubscribe else max(host.slots for host in machines)
    if hosts.ports and hosts.ports[1] - hosts.ports[0] < most:
        _refuse(f"--ports {ports}: a machine with {most} ranks needs {most + 1}, one for each and one for Open MPI.")
    return replace(hosts, network=_network(interface)) if interface else hosts


def _digest(path):
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _has_network(network, interfaces, addresses):
    """Whether a machine with these interfaces and addresses has it; every one has its loopback."""
    return network in interfaces or ("/" in network and any(
        ipaddress.ip_address(address) in ipaddress.IPv4Network(network) for address in [*addresses, "127.0.0.1"] if ":" not in address))


def _check_network_here(network):
    addresses = subprocess.run(["hostname", "-I"], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False).stdout.split()
    interfaces = [name for _, name in socket.if_nameindex()]
    if not _has_network(network, interfaces, addresses):
        _refuse(f"--interface {network}: this machine has no such network; it has {', '.join(interfaces)}.")


def examine(hosts, files):
    """Asks each other machine whether it can be reached without a password and has the same `files`, at the same paths, and all of them
    whether they have the network. Raises Error."""
    agent = shlex.split(os.environ.get(AGENT, "ssh -o BatchMode=yes"))
    if hosts.others and shutil.which(agent[0]) is None:
        _refuse(f"--hosts: there is no {agent[0]} on this machine, by which Open MPI reaches the others (Debian package openssh-client).")
    paths = " ".join(shlex.quote(str(path)) for path in files)
    question = (f"command -v orted >/dev/null && echo orted; hostname -I; ls /sys/class/net | tr '\\n' ' '; echo; "
                f"sha256sum -- {paths} 2>/dev/null; true")
    for host in hosts.others:
        try:
            answer = subprocess.run([*agent, host.name, question], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                    timeout=ANSWER_S, check=False)
        except subprocess.TimeoutExpired:
            _refuse(f"--hosts: {host.name} did not answer within {ANSWER_S} s ({shlex.join([*agent, host.name])}).")
        lines = answer.stdout.splitlines()
        if answer.returncode != 0:
            said = answer.stderr.strip().splitlines()
            _refuse(f"--hosts: {host.name} cannot be reached by {agent[0]} without a password"
                    + (f": {said[-1]}" if said else "") + ". Open MPI starts its ranks that way.")
        if "orted" not in lines[:1]:
            _refuse(f"--hosts: {host.name} has no Open MPI (orted is not on its PATH; Debian package openmpi-bin).")
        if not _has_network(hosts.network, lines[2].split(), lines[1].split()):
            _refuse(f"--interface {hosts.network}: {host.name} has no such network.")
        found = {line[66:]: line[:64] for line in lines[3:]}
        for path in files:
            if str(path) not in found:
                _refuse(f"--hosts: {host.name} has no {path}. All machines need the same build and case at the same paths, as a shared "
                        "file system has them.")
            if found[str(path)] != _digest(path):
                _refuse(f"--hosts: {path} on {host.name} is another file than here. All machines need the same build and case.")
    _check_network_here(hosts.network)
