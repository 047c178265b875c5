"""./tern run: validates, starts the processes a case needs, watches them, and leaves one run.json."""

import json
import os
import shlex
import shutil
import sys
import time
from datetime import datetime, timezone
from pathlib import Path

from launcher import build, cases, first_cause, packages, summary
from launcher.errors import BAD_INPUT, DONE, INPUT_OUTPUT, STATUS, LauncherError
from launcher.processes import Group, Interrupts

ROLES = ("coupler", "fluid", "structure")  # the order of starting: the coupler binds the endpoint


def write_json(path, value):
    """Writes `value` so that a reader sees the old or the new file, never half of one."""
    temporary = path.with_suffix(".tmp")
    temporary.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, path)


def roles_of(case, only):
    """The processes this case needs: a side it does not have is not started, one side alone needs no coupler."""
    sides = [role for role in ("fluid", "structure") if case[f"has_{role}"]]
    needed = ["coupler", *sides] if len(sides) == 2 else sides
    if only is None:
        return needed
    if only not in needed:
        raise LauncherError(BAD_INPUT, f"--only {only}: the case {case['name']} needs no {only} process, only "
                                       f"{' and '.join(needed)}.")
    return [only]


def foreign_command(text, role, case, roles):
    """The words of a command that takes the place of tern-ROLE, its program found; None for no command."""
    if text is None:
        return None
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise LauncherError(BAD_INPUT, f"--{role} {text!r} cannot be split into words: {error}.") from error
    if not words:
        raise LauncherError(BAD_INPUT, f"--{role} is empty; give the command that takes the place of tern-{role}.")
    if not (case["has_fluid"] and case["has_structure"]):
        raise LauncherError(BAD_INPUT, f"--{role}: the case {case['name']} is not coupled; one side can be replaced only where "
                                       "there are two.")
    if role not in roles:
        raise LauncherError(BAD_INPUT, f"--{role} is of no use with --only {roles[0]}.")
    program = shutil.which(words[0])
    if program is None:
        reason = ("is not executable; make it so (chmod +x), or put its interpreter before it" if os.path.isfile(words[0])
                  else "is neither a file nor a program on the PATH")
        raise LauncherError(BAD_INPUT, f"--{role}: {words[0]} {reason}.")
    return [os.path.abspath(program), *words[1:]]


def foreign_environment(directory, threads):
    """What a participant started by us finds: the build that reads cases, the Python library of participants, and as many
    threads in the libraries it uses as tern's own processes have."""
    library = str(build.ROOT / "proto" / "python")
    threads = str(threads or 1)
    return os.environ | {"TERN_BUILD": str(directory), "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads,
                         "PYTHONPATH": os.pathsep.join(filter(None, (library, os.environ.get("PYTHONPATH"))))}


def _reports(out, roles):
    """report.<role>.json of each role; an empty one where it is missing or unreadable."""
    reports = {}
    for role in roles:
        try:
            reports[role] = json.loads((out / f"report.{role}.json").read_text(encoding="utf-8"))
        except (OSError, json.JSONDecodeError):
            reports[role] = {}
    return reports


def _merged(run, processes, reports, cause, wall_s):
    """The contents of run.json after the end."""
    any_report = next((report for report in reports.values() if report), {})
    for process in processes:
        report = reports.setdefault(process.role, {})
        report["program"] = process.program
        report["exit_code"] = process.exit_code
        report["cpu_s"] = process.cpu_s
        if report.get("status") in (None, "running"):
            report["status"] = "killed" if process.exit_code < 0 else "failed" if process.exit_code or process.never_joined else "done"
    return run | {
        "status": STATUS[cause.exit_code], "exit_code": cause.exit_code, "first_cause": cause.sentence,
        "first_cause_role": cause.role,
        "exit_codes": {process.role: process.exit_code for process in processes},
        "wall_s": wall_s, "cpu_s": sum(process.cpu_s for process in processes),
        "steps": max((report.get("steps") or 0 for report in reports.values()), default=0),
        "version": any_report.get("version", ""), "git": any_report.get("git", ""),
        "processes": reports,
    }


def run(arguments):
    """Runs a case. Returns (exit code, directory of the results)."""
    path = cases.find(arguments.case)
    directory = build.ensure(arguments.build)
    case_options = arguments.case_options
    case = cases.read(directory, path, case_options)
    roles = roles_of(case, arguments.only)
    commands = {role: command for role in ("fluid", "structure")
                if (command := foreign_command(getattr(arguments, role), role, case, roles))}
    for command in commands.values():
        packages.ensure_for(command)
    out = cases.make_out_directory(case["name"], arguments.out, arguments.force)
    if not arguments.quiet:
        # Said before the first progress line: where the results appear, and under which name.
        print(f"tern: {case['name']} ({', '.join(roles)}), results in {summary.shown(out)}", flush=True)

        for warning in case.get("warnings", []):
            print(f"tern: warning: {warning}", file=sys.stderr, flush=True)

    contents = {"case": case["name"], "case_path": str(path), "title": case.get("title", ""), "case_hash": case["hash"],
                "started": datetime.now(timezone.utc).isoformat(timespec="seconds"), "status": "running",
                "settings": case.get("settings", {}), "options": case_options,
                "commands": {role: shlex.join(command) for role, command in commands.items()}}
    options = [*case_options, "--out", str(out), *arguments.network_options]
    if arguments.until is not None:
        options += ["--until", repr(arguments.until)]
    if arguments.threads is not None:
        options += ["--threads", str(arguments.threads)]
    if arguments.deadline is not None and (len(roles) > 1 or arguments.only):
        options += ["--deadline", repr(arguments.deadline)]
    if arguments.force:
        options.append("--force")
    if arguments.allow_unstable:
        options.append("--allow-unstable")
    began = time.monotonic()
    with Interrupts() as interrupts, Group() as group:
        endpoint = arguments.endpoint or f"ipc://{group.directory}/tern.sock"
        try:
            write_json(out / "run.json", contents)
            for role in roles:
                own = list(options)
                if len(roles) > 1 or arguments.only:
                    own += ["--endpoint", endpoint]
                if arguments.record and role == "coupler":
                    own.append("--record")
                if arguments.quiet or (len(roles) > 1 and role != "coupler"):
                    own.append("--quiet")  # one progress line: the coupler's, or that of the process that runs alone
                if role in commands:
                    group.start(role, [*commands[role], str(path), *own], Path(commands[role][0]).name,
                                foreign_environment(directory, arguments.threads))
                else:
                    group.start(role, [str(directory / f"tern-{role}"), str(path), *own])
        except OSError as error:
            raise LauncherError(INPUT_OUTPUT, f"The run could not be started: {error}.") from error
        group.supervise(interrupts, (out / "steps.csv").exists if "coupler" in roles else lambda: True)
        wall_s = time.monotonic() - began
        for half_written in out.glob("*.tmp"):  # by a process that was killed while it wrote
            half_written.unlink(missing_ok=True)
        reports = _reports(out, roles)
        cause = first_cause.find(group.processes, reports, interrupts.count > 0)
        contents = _merged(contents, group.processes, reports, cause, wall_s)
        try:
            write_json(out / "run.json", contents)
            for role in roles:
                (out / f"report.{role}.json").unlink(missing_ok=True)
        except OSError as error:
            if cause.exit_code == DONE:
                raise LauncherError(INPUT_OUTPUT, f"The results are in {out}, but run.json could not be written: "
                                                  f"{error}.") from error
    if not arguments.quiet:
        print(summary.text(contents, out), flush=True)
    return cause, out
