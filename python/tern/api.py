"""tern.run() and tern.study(): what ./tern run and ./tern study do, for scripts and notebooks."""

import json

from tern.errors import DONE, INTERRUPTED, RunFailed
from tern.launch import run as launch
from tern.results.run import Run


def _words(settings):
    """KEY=VALUE of --set from a dict: a text as it is, numbers, booleans and lists as a case file has them."""
    return [f"{key}={value if isinstance(value, str) else json.dumps(value, default=lambda number: number.tolist())}"
            for key, value in (settings or {}).items()]


def run(case, set=None, out=None, *, preset=None, until=None, threads=None, deadline=None, force=False, quiet=True, fluid=None,
        structure=None, record=False, allow_unstable=False, build="release"):
    """Runs a case as ./tern run does and returns its results, a tern.Run. Installs and builds what is missing.

        run = tern.run("dam_break_plate", {"fluid.spacing": 0.008}, until=0.3)

    case       a case.toml, the folder of one, or a name: in ./cases, or of the cases that come with tern
    set        {key: value}: overrides keys of the case, in the units of docs/PARAMETERS.md
    out        directory of the results (default runs/<case>; an earlier run is kept: -2, -3, ...); `force` replaces what is in it
    preset     "draft", "standard", "reference" or "paper"
    until      end time [s] instead of the case's own
    threads    of each process (default: as many as its work is worth; the results have the same bits for any number)
    deadline   give a process up that leaves a message out for so long [s] (default 300)
    quiet      False: say where the results go and how far the run is
    fluid, structure   a command in place of tern-fluid or tern-structure (docs/PARTICIPANTS.md)
    record     keep all messages, to play one side back
    build      "release", "debug", "asan" or "tsan"
    allow_unstable     run the explicit coupling although the added mass predicts that it is unstable

    Raises tern.RunFailed (a tern.Error) with exit code and first cause when the run ends early, tern.Error for a case or an option
    that is wrong, and KeyboardInterrupt after Ctrl-C, when the processes have ended; what was computed stays readable.
    """
    options = [part for setting in _words(set) for part in ("--set", setting)] + (["--preset", preset] if preset else [])
    cause, directory = launch.run(launch.Request(
        str(case), options, out=None if out is None else str(out), force=force, until=None if until is None else float(until),
        threads=threads, deadline=deadline, quiet=quiet, build=build, fluid=fluid, structure=structure, record=record,
        allow_unstable=allow_unstable))
    if cause.exit_code == INTERRUPTED:
        raise KeyboardInterrupt
    if cause.exit_code != DONE:
        raise RunFailed(cause.exit_code, cause.sentence, cause.role, directory)
    return Run(directory)


def study(case, parameters=None, *, levels=2, budget=None, until=None, set=None, out=None, keep=False):
    """Measures what the parameters of a case cost and gain, as ./tern study does; returns a list of rows, one per run.

        for row in tern.study("hydrostatic_tank", ["fluid.spacing"], budget=5):
            print(row.options, row.error, row.cpu_s)

    parameters   names such as "fluid.spacing", "courant", "preset" (default: all the scene has); `levels` values of each at most
    budget       minutes; what is not expected to fit is left out, cheap runs come first
    until        end time [s] of every run (default: of study.toml, or of the case)
    set          {key: value}: changes the case all runs start from
    out          where the study is kept and resumed (default runs/study-<case>)
    keep         count runs of another version of tern instead of doing them again

    Of a row: `point` its name, `parameter` and `value` what was changed, `options` what ./tern run takes for it, `status`, `cause`; `error`
    (root mean square over the quantities with a reference, a share of 1), `distance_to_finest`, `distance_to_standard` (of the gauges'
    curves, shares of 1); `cpu_s`, `wall_s` [s], `steps`, `pressure_iterations`. None is what is not known. Raises as run() does, but
    for runs that end early: those are rows.
    """
    from tern.studies import command
    one = command.Study(command.Request(str(case), list(parameters or []), levels, budget, until, _words(set),
                                        None if out is None else str(out), keep))
    left_out, interrupted = one.run()
    one.write(left_out)
    if interrupted:
        raise KeyboardInterrupt
    return one.rows
