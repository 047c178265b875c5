"""./tern conform: does a participant keep the protocol? The checks are in tern/participant/conformance.py."""

from tern.launch import build, cases, packages, run
from tern.errors import BAD_INPUT, DONE, NUMERICAL_FAILURE, Error


def conform(arguments):
    """Runs the checks, prints one line for each; exit code 0 when all hold, 3 when one does not."""
    packages.ensure(["protobuf-compiler", *packages.PYTHON])
    from tern.participant import conformance  # needs them

    unknown = [name for name in arguments.check if name not in conformance.CHECKS]
    if unknown:
        raise Error(BAD_INPUT, f"There is no check {unknown[0]!r}; there are {', '.join(conformance.CHECKS)}.")
    address = arguments.target if arguments.target.startswith(("tcp://", "ipc://")) else None
    directory = build.ensure(arguments.build, ["tern-case", "tern-structure"])
    scene = cases.read(directory, cases.find(arguments.case), arguments.case_options)
    for side in ("fluid", "structure"):
        if not scene[f"has_{side}"]:
            raise Error(BAD_INPUT, f"The case {scene['name']} has no {side}: a participant is tested in a case with both.")
    if scene["settings"].get("coupling", {}).get("algorithm") == "explicit":
        raise Error(BAD_INPUT, f"The case {scene['name']} has coupling.algorithm explicit: what is asked of a participant is that of "
                               "auto, the default, and more than explicit asks. Add --set coupling.algorithm=auto.")
    command = None if address else run.foreign_command(arguments.target, arguments.role, scene, ["fluid", "structure"])
    if command:
        packages.ensure_for(command)
    environment = run.foreign_environment(directory, None)
    print(f"tern: {arguments.target} as the {arguments.role} of {scene['name']}", flush=True)
    subject = conformance.Subject(arguments.role, scene, command, arguments.case_options, environment, address)

    def say(line):
        print(line, flush=True)

    at_rest = None
    try:
        if arguments.role == "fluid":
            own = conformance.Subject("structure", scene, [str(directory / "tern-structure")], arguments.case_options, environment)
            at_rest = conformance.surface_of(own, say)
        findings = conformance.run(subject, arguments.check or list(conformance.CHECKS), at_rest, say)
    except conformance.CannotBind as error:
        raise Error(BAD_INPUT, str(error)) from None
    broken = [name for name, breach in findings.items() if breach]
    print(f"tern: {len(findings) - len(broken)} of {len(findings)} checks hold"
          + (f"; broken: {', '.join(broken)}" if broken else ""), flush=True)
    return NUMERICAL_FAILURE if broken else DONE
