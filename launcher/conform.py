"""./tern conform: does a participant keep the protocol? The checks are in proto/python/conformance.py."""

import shlex
import shutil
import sys

from launcher import build, cases
from launcher.errors import BAD_INPUT, DONE, NUMERICAL_FAILURE, LauncherError

sys.path.insert(0, str(build.ROOT / "proto" / "python"))


def _command(target):
    """The words of a command, whose first must be an executable."""
    words = shlex.split(target)
    if not words or shutil.which(words[0]) is None:
        raise LauncherError(BAD_INPUT, f"{target!r} is neither an address (tcp://..., ipc://...) nor a command: there is no "
                                       f"executable {words[0] if words else target!r}.")
    return [shutil.which(words[0]), *words[1:]]


def conform(arguments):
    """Runs the checks, prints one line for each; exit code 0 when all hold, 3 when one does not."""
    import conformance  # needs zmq and protobuf

    unknown = [name for name in arguments.check if name not in conformance.CHECKS]
    if unknown:
        raise LauncherError(BAD_INPUT, f"There is no check {unknown[0]!r}; there are {', '.join(conformance.CHECKS)}.")
    address = arguments.target if arguments.target.startswith(("tcp://", "ipc://")) else None
    command = None if address else _command(arguments.target)
    directory = build.ensure(arguments.build, ["tern-case", "tern-structure"])
    scene = cases.read(directory, cases.find(arguments.case), arguments.case_options)
    for side in ("fluid", "structure"):
        if not scene[f"has_{side}"]:
            raise LauncherError(BAD_INPUT, f"The case {scene['name']} has no {side}: a participant is tested in a case with both.")
    print(f"tern: {arguments.target} as the {arguments.role} of {scene['name']}", flush=True)
    subject = conformance.Subject(arguments.role, scene, command, arguments.case_options, address)

    def say(line):
        print(line, flush=True)

    at_rest = None
    if arguments.role == "fluid":
        own = conformance.Subject("structure", scene, [str(directory / "tern-structure")], arguments.case_options)
        at_rest = conformance.surface_of(own, say)
    findings = conformance.run(subject, arguments.check or list(conformance.CHECKS), at_rest, say)
    broken = [name for name, breach in findings.items() if breach]
    print(f"tern: {len(findings) - len(broken)} of {len(findings)} checks hold"
          + (f"; broken: {', '.join(broken)}" if broken else ""), flush=True)
    return NUMERICAL_FAILURE if broken else DONE
