"""./tern keys: one pair of CURVE keys for each role, and which file belongs on which machine."""

import os
from pathlib import Path

from tern.launch import packages
from tern.errors import BAD_INPUT, INPUT_OUTPUT, Error

ROLES = ("coupler", "fluid", "structure")
ALLOW_LIST = "participants.allowed"  # as in proto/transport/keys.hpp

EXPLANATION = """tern: made the keys of coupler, fluid and structure in {directory}
  On the machine of ...   must be (in a directory for --keys)
  the coupler             coupler.secret    {allow_list}
  the fluid               fluid.secret      coupler.public
  the structure           structure.secret  coupler.public
Copy each .secret over a safe way (scp) to its own machine only, with mode 600, and remove it here if this is another one.
The .public files and {allow_list} are no secrets; who can change them decides who is trusted.
Then:
  ./tern run CASE --only coupler --bind tcp://HOST:PORT --keys DIR
  ./tern join fluid tcp://HOST:PORT CASE --keys DIR
  ./tern join structure tcp://HOST:PORT CASE --keys DIR"""


def _write(path, text, mode):
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    with os.fdopen(descriptor, "w", encoding="ascii") as file:
        os.fchmod(descriptor, mode)  # whatever the umask
        file.write(text)


def make(directory):
    """Writes the keys into `directory`; never over earlier ones."""
    packages.ensure(["python3-zmq"])
    import zmq
    directory = Path(directory)
    names = [f"{role}.{kind}" for role in ROLES for kind in ("secret", "public")] + [ALLOW_LIST]
    present = [name for name in names if os.path.lexists(directory / name)]
    if present:
        raise Error(BAD_INPUT, f"{directory} holds {', '.join(present)} already; keys are never overwritten: choose another "
                                       f"directory, or remove the old ones on all machines.")
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        pairs = {role: [key.decode("ascii") for key in zmq.curve_keypair()] for role in ROLES}
        for role, (public, secret) in pairs.items():
            _write(directory / f"{role}.secret", secret + "\n", 0o600)
            _write(directory / f"{role}.public", public + "\n", 0o644)
        _write(directory / ALLOW_LIST, "".join(f"{role} {pairs[role][0]}\n" for role in ROLES[1:]), 0o644)
    except OSError as error:
        raise Error(INPUT_OUTPUT, f"The keys cannot be written to {directory} ({os.strerror(error.errno)}); choose another "
                                          f"directory.") from error
    print(EXPLANATION.format(directory=directory, allow_list=ALLOW_LIST))
