"""The command line of ./tern: one parser per command, each with units and examples in its help."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from tern import paths, scale_model
from tern.errors import BAD_INPUT, DONE, INPUT_OUTPUT, INTERRUPTED, NUMERICAL_FAILURE, PEER_LOST, Error, refusal
from tern.launch import build, cases, packages, resumption, run
from tern.results import summary

DESCRIPTION = """tern: fluid-structure simulation with three processes: an incompressible-SPH fluid, a
total-Lagrangian-SPH structure, and a coupler between them."""

EPILOG = """first steps:
  ./tern run dam_break_plate             installs what is missing, builds, runs the case
  ./tern plot runs/dam_break_plate       pictures of fields, gauges, energies and steps
  ./tern report runs/dam_break_plate     the same and more as one page for the browser
  ./tern test                            all tests

exit codes: 0 done, 2 bad input, 3 numerical failure (or: a band or test failed), 4 peer lost or timed out,
5 input/output, 130 interrupted. A run returns its first cause.
environment: TERN_BUILD=DIR uses a finished build directory instead of build/release."""

CASE_HELP = "a case.toml, the folder of one, or a name under cases/"


def _case_options(parser, case_count=None):
    parser.add_argument("case", metavar="CASE", nargs=case_count, help=CASE_HELP)
    _override_options(parser)


def _override_options(parser):
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[],
                        help="override one key of the case, e.g. fluid.spacing=0.002 (may be repeated; recorded in run.json)")
    parser.add_argument("--preset", help="named group of numerical settings: draft, standard, reference or paper")
    parser.add_argument("--build", choices=build.PRESETS, default="release", help="build to use (default release)")


def _positive_number(text):
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def _plane(text):
    axis, _, place = text.partition("=")
    try:
        return "xyz".index(axis or "?"), float(place)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text} is not a plane; write for example z=0.1, in m") from None


def _camera(text):
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if not (len(numbers) in (2, 3) and abs(numbers[0]) <= 360 and abs(numbers[1]) <= 90 and all(0 < zoom <= 100 for zoom in numbers[2:])):
        raise argparse.ArgumentTypeError(f"{text} is not a camera; write for example 30,20 or 30,20,1.5: an azimuth up to 360 and an "
                                         "elevation up to 90 degrees, and a zoom above 0")
    return numbers


def _absolute(text):
    """Of a file that a run that goes on elsewhere has to find again."""
    return str(Path(text).resolve())


def _count(text):
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number greater than 0")
    return value


def _thread_count(text):
    try:
        value = int(text)
    except ValueError:
        value = 0
    if not 1 <= value <= 256:  # most_threads of run/command_line.cpp
        raise argparse.ArgumentTypeError(f"{text} is not a whole number from 1 to 256; give the cores for each process, or leave it out")
    return value


def _run_options(parser):
    parser.add_argument("--until", metavar="T", type=_positive_number, help="end time [s] instead of the case's own")
    parser.add_argument("--threads", metavar="N", type=_thread_count,
                        help="threads of each process (default: what its work is worth; the results have the same bits for any number)")
    parser.add_argument("--deadline", metavar="S", type=_positive_number,
                        help="give a process up that leaves a message out for S seconds (default 300; more for a slow solver); to join, "
                             "all have 300")
    parser.add_argument("--quiet", action="store_true", help="say nothing unless something fails")


def _ranks_options(parser):
    parser.add_argument("--ranks", metavar="N", type=_count,
                        help="run the fluid in N processes (docs/SCALE.md); another N has other last digits")
    parser.add_argument("--oversubscribe", action="store_true", help="with --ranks: even where there are fewer cores")
    parser.add_argument("--hosts", metavar="FILE", type=_absolute,
                        help="with --ranks: on these machines, one a line as NAME slots=K, this one first")
    parser.add_argument("--interface", metavar="NETWORK", help="with --hosts: the network interface between them, as ib0, or their "
                        "network, as 10.1.0.0/16; Open MPI listens there alone")
    parser.add_argument("--ports", metavar="FIRST-LAST", help="with --hosts: the ports that Open MPI opens on each machine (default: any)")


def _retries_option(parser):
    parser.add_argument("--retries", metavar="N", type=_count, default=0,
                        help="after a lost process or machine go on from the newest checkpoint, at most N times")


def _network_options(parser):
    parser.add_argument("--keys", metavar="DIR", help="directory with this role's keys, made by ./tern keys: encrypts and authenticates")
    parser.add_argument("--insecure", action="store_true", help="use a network address without keys")


def _look_options(parser, whose):
    parser.add_argument("--camera", metavar="AZIMUTH,ELEVATION[,ZOOM]", type=_camera, help=whose + "from where it is seen: turned "
                        "from the front to the right and raised, in degrees; ZOOM 2 shows half as much (default 30,20,1; a negative one as "
                        "in --camera=-30,20)")
    parser.add_argument("--clip", metavar="AXIS=M", type=_plane, help=whose + "leave away what lies in front of this plane [m], e.g. z=0.1")


def _add(commands, name, function, summary, examples):
    parser = commands.add_parser(name, help=summary, description=summary[0].upper() + summary[1:] + ".",
                                 epilog="examples:\n" + "\n".join(f"  {line}" for line in examples),
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(function=function)
    return parser


def parser():
    """The whole command line."""
    whole = argparse.ArgumentParser(prog="tern", description=DESCRIPTION, epilog=EPILOG,
                                    formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = whole.add_subparsers(metavar="COMMAND", required=True)

    one = _add(commands, "run", _run, "run a case and leave its results in one directory",
               ["./tern run dam_break_plate", "./tern run dam_break_plate --until 0.3 --set fluid.spacing=0.008",
                "./tern run piston --structure \"rigid_spring.py --stiffness 2e7\"",
                "./tern run CASE --only fluid --endpoint ipc:///tmp/mine.sock   (the other two are started by hand)",
                "./tern run CASE --only coupler --bind tcp://0.0.0.0:5555 --keys DIR   (the other two come over the network)"])
    _case_options(one)
    one.add_argument("--out", metavar="DIR", help="results directory (default runs/<case>; an earlier run is kept: -2, -3, ...)")
    one.add_argument("--force", action="store_true", help="replace the results of an earlier run in the directory")
    one.add_argument("--allow-unstable", action="store_true",
                     help="run the explicit coupling although the added mass predicts that it is unstable")
    for role in ("fluid", "structure"):
        one.add_argument(f"--{role}", metavar="COMMAND", help=f"program to start in place of tern-{role}, with its options; it is "
                         "given those of tern-" + role + " in addition (docs/PARTICIPANTS.md)")
    _ranks_options(one)
    one.add_argument("--record", action="store_true", help="keep all messages of fluid and structure in interface.record, from which "
                     "either can be played back (docs/PARTICIPANTS.md)")
    one.add_argument("--only", choices=("fluid", "structure", "coupler"), help="start this process only")
    one.add_argument("--endpoint", metavar="ADDRESS", help="where the coupler listens, e.g. ipc:///tmp/mine.sock "
                     "(default: a private socket)")
    one.add_argument("--resume", choices=("auto",), help="auto: go on from the newest checkpoint if the results directory holds an "
                     "earlier run of this case, otherwise begin")
    _retries_option(one)
    _run_options(one)
    one.add_argument("--bind", metavar="ADDRESS", help="with --only coupler: the same for a network, tcp://HOST:PORT with the name "
                     "or number of this machine's interface, 0.0.0.0 for all, PORT * for any free one")
    _network_options(one)

    one = _add(commands, "resume", _resume, "go on with a run from its newest checkpoint, into the same directory",
               ["./tern resume runs/dam_break_plate", "./tern resume runs/dam_break_plate --until 2      (a longer end)",
                "./tern resume runs/dam_break_plate --set output.frame_interval=0.01"])
    one.add_argument("run", metavar="RUN", help="directory of a run that was interrupted, killed, or is to go on beyond its end")
    one.add_argument("--set", metavar="KEY=VALUE", action="append", default=[],
                     help="change end_time or an interval of [output] for the rest; all else must be as it was")
    _ranks_options(one)
    _retries_option(one)
    _run_options(one)
    one.add_argument("--build", choices=build.PRESETS, default="release", help="build to use (default release)")

    one = _add(commands, "join", _join, "start one participant of a run whose coupler is on another machine",
               ["./tern join fluid tcp://coupler.example.org:5555 CASE --keys DIR",
                "./tern join structure tcp://192.168.1.20:5555 CASE --keys DIR --out DIR   (results stay on this machine)"])
    one.add_argument("role", metavar="ROLE", choices=("fluid", "structure"), help="fluid or structure")
    one.add_argument("--command", metavar="COMMAND", help="a solver of your own in place of tern's (docs/PARTICIPANTS.md)")
    one.add_argument("endpoint", metavar="ADDRESS", help="where the coupler listens: tcp://HOST:PORT")
    _case_options(one)
    one.add_argument("--out", metavar="DIR", help="results directory (default runs/<case>; an earlier run is kept: -2, -3, ...)")
    one.add_argument("--force", action="store_true", help="replace the results of an earlier run in the directory")
    _network_options(one)
    _ranks_options(one)
    _run_options(one)

    one = _add(commands, "keys", _keys, "make the keys of a run over a network, and say which belongs where",
               ["./tern keys ~/tern-keys"])
    one.add_argument("directory", metavar="DIR", help="where to put them; made if missing, earlier keys are never overwritten")

    one = _add(commands, "python", _python,
               "run Python with tern and what it needs importable: a script, a module, or nothing to type at it",
               ["./tern python cases/dam_break_plate/convergence.py --until 0.4", "./tern python my_script.py        (import tern)",
                "./tern python                     (import tern; help(tern))"])
    one.add_argument("words", metavar="...", nargs=argparse.REMAINDER, help="what python3 takes: FILE ARGUMENTS, -m MODULE ARGUMENTS")

    one = _add(commands, "test", _test, "build and run all tests",
               ["./tern test", "./tern test -L unit       (labels: unit, verify, process)",
                "./tern test --build ranks -L ranks     (a fluid in many processes)",
                "./tern test -L fuzz       (fuzzers of messages and case files, a minute each; not part of the others)",
                "./tern test --build asan"])
    one.add_argument("-L", "--label", metavar="LABEL", help="only tests with this label: unit, verify, process, fuzz or ranks")
    one.add_argument("--build", choices=build.PRESETS, default="release", help="build to test (default release)")

    one = _add(commands, "check", _case_tool, "validate a case; print particles, step limits, memory, expected time",
               ["./tern check dam_break_plate", "./tern check dam_break_plate --set fluid.spacing=0.002",
                "./tern check dam_break_plate --picture              (draws the scene into runs/dam_break_plate-start.png)",
                "./tern check dam_break_3d --picture scene.png --camera 60,15 --clip z=0.1"])
    one.set_defaults(tool="check")
    _case_options(one)
    one.add_argument("--picture", metavar="FILE", nargs="?", const="", help="also draw the scene before the first step, as PNG, PDF or SVG "
                     "by the end of FILE: particles, bodies, clamps, walls and where they go, gauges (default runs/<case>-start.png)")
    _look_options(one, "of a 3D case, with --picture, ")

    one = _add(commands, "explain", _case_tool, "say in plain words what a case models, what not, and what each part costs",
               ["./tern explain dam_break_plate", "./tern explain dam_break_3d --ranks 64 --cluster cluster.toml"])
    one.set_defaults(tool="explain")
    _case_options(one)
    one.add_argument("--ranks", metavar="N", type=_count, help="also what the fluid would cost in N processes, by a model (docs/SCALE.md)")
    one.add_argument("--cluster", metavar="FILE", help="with --ranks: the machines, in three lines as cores = 32, latency_us = 1.5, "
                     "bandwidth_gb_per_s = 10 (default: machines like this one)")

    one = _add(commands, "verify", _verify, "hold the results of cases against their expected.toml",
               ["./tern verify hydrostatic_tank", "./tern verify                    (every case with an expected.toml)",
                "./tern verify dam_break_plate --run runs/dam_break_plate   (a run that exists already)"])
    _case_options(one, "*")
    one.add_argument("--run", metavar="DIR", help="use the results in DIR instead of running the case (one CASE only)")
    one.add_argument("--json", action="store_true", help="print the table as JSON")
    _run_options(one)

    one = _add(commands, "study", _study, "measure what every parameter of a case costs and buys, and say which settings to take",
               ["./tern study gray_cantilever", "./tern study dam_break_plate --budget 60 --parameters fluid.spacing,courant",
                "./tern study hydrostatic_tank --error 1%     (from what is measured already, if anything is)",
                "./tern study dam_break_front --time 5s", "./tern study CASE --write-docs   (its table to docs/trade, docs/TRADE.md anew)"])
    one.add_argument("case", metavar="CASE", nargs="?", help=CASE_HELP)
    one.add_argument("--parameters", metavar="NAME,...", action="append", default=[],
                     help="only these, e.g. fluid.spacing, pressure_tolerance, preset (default: all the scene has)")
    one.add_argument("--knobs", action="append", default=[], help=argparse.SUPPRESS)  # its name one version ago
    one.add_argument("--levels", metavar="N", type=_count, default=2, help="values tried of every parameter, at most (default 2)")
    one.add_argument("--budget", metavar="MINUTES", type=_positive_number,
                     help="leave out what is not expected to fit; cheap points come first")
    one.add_argument("--until", metavar="T", type=_positive_number,
                     help="end time [s] of every run (default: of study.toml, or of the case)")
    one.add_argument("--error", metavar="E", help="say which settings to take for this error, e.g. 5%%")
    one.add_argument("--time", metavar="T", help="say which settings to take for this wall time, e.g. 60s")
    one.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="change the case all points start from")
    one.add_argument("--out", metavar="DIR", help="where the study is kept and resumed (default runs/study-<case>)")
    one.add_argument("--keep", action="store_true", help="count points measured by another version of tern instead of running them again")
    one.add_argument("--write-docs", action="store_true",
                     help="copy the table to docs/trade and write docs/TRADE.md and the README from all of them; "
                     "runs nothing")

    one = _add(commands, "conform", _conform, "test whether a participant, yours or ours, keeps the protocol (docs/PROTOCOL.md)",
               ["./tern conform structure \"/usr/bin/python3 my_structure.py\"   (started anew for every check)",
                "./tern conform fluid build/release/tern-fluid",
                "./tern conform structure tcp://127.0.0.1:5555               (you start it when asked to)"])
    one.add_argument("role", choices=("fluid", "structure"), help="what the participant is")
    one.add_argument("target", metavar="COMMAND|ADDRESS", help="the command that starts it, to which CASE --out DIR --endpoint "
                     "ADDRESS --quiet are appended; or the address where you let it connect")
    one.add_argument("--case", default="conformance", help=CASE_HELP + " (default: cases/conformance, a plate in shallow water)")
    one.add_argument("--check", metavar="NAME", action="append", default=[], help="only this check (may be repeated)")
    _override_options(one)

    one = _add(commands, "status", _status, "say how a run is doing: how far, which process lives, who waits for whom",
               ["./tern status runs/dam_break_plate"])
    one.add_argument("runs", metavar="RUN", nargs="+", help="directory of a run")

    one = _add(commands, "extremes", _extremes, "map where the method holds and how it fails, by some hundred short runs",
               ["./tern extremes --quick", "./tern extremes --only spray", "./tern extremes --random 30 --seed 1",
                "./tern extremes                    (all of it; begun again after Ctrl-C, it goes on where it was)"])
    one.add_argument("--quick", action="store_true", help="one or two cells of most families, less than a minute")
    one.add_argument("--only", metavar="FAMILY", help="this family only: plates, poisson, ... (a wrong name lists them), or boundary")
    one.add_argument("--random", metavar="N", type=int, help="N random scenes with all defaults in place of the map")
    one.add_argument("--seed", metavar="S", type=int, help="of the random scenes (default: drawn and said)")
    one.add_argument("--out", metavar="DIR", help="where table, page and pictures go (default runs/extremes)")
    one.add_argument("--page", metavar="FILE", help="also put the result into a page, between its markers (docs/STABILITY.md)")
    one.add_argument("--quiet", action="store_true", help="print what is wrong, nothing else")
    one.add_argument("--build", choices=build.PRESETS, default="release", help="build to use (default release)")

    one = _add(commands, "plot", _plot, "pictures of a run; with several runs, also their gauges in one picture",
               ["./tern plot runs/dam_break_plate", "./tern plot runs/dam_break_plate --times 0.28 0.50 0.80",
                "./tern plot runs/dam_break_plate runs/dam_break_plate-2",
                "./tern plot runs/dam_break_3d --camera 30,20 --clip z=0.1    (a 3D run is rendered, without a display too)",
                "./tern plot runs/dam_break_3d --slice z=0.1              (writes plots/field_..._slice_z0.1.png)",
                "./tern plot runs/dam_break_plate --animate --field speed     (writes runs/dam_break_plate/film_speed.mp4)"])
    one.add_argument("runs", metavar="RUN", nargs="+", help="directory of a run")
    one.add_argument("--times", metavar="T", nargs="+", type=float, help="times of the field pictures [s] (default: four)")
    one.add_argument("--animate", action="store_true", help="a film of the frames instead, RUN/film.mp4 (H.264)")
    one.add_argument("--fps", metavar="N", type=_positive_number, help="pictures per second of the film (default: it lasts about 8 s)")
    _look_options(one, "of a 3D run ")
    one.add_argument("--slice", metavar="AXIS=M", type=_plane, help="of a 3D run draw the particles within a spacing of this plane [m] "
                     "instead of the scene; for --animate too")
    one.add_argument("--field", choices=("pressure", "speed"), help="what colours the film (default pressure, and shear stress of "
                     "the structure)")

    one = _add(commands, "report", _report, "one HTML page of runs: curves against references, fields, costs, settings; of studies too",
               ["./tern report runs/dam_break_plate                          (writes runs/dam_break_plate/report.html)",
                "./tern report runs/dam_break_plate --times 0.28 0.50 0.80", "./tern report runs/coarse runs/fine --out compared.html"])
    one.add_argument("directories", metavar="RUN", nargs="+", help="directory of a run, or any with tables, pictures and Markdown")
    one.add_argument("--out", metavar="FILE", help="the page (default report.html in the directory; for several, in the one that "
                     "holds them)")
    one.add_argument("--times", metavar="T", nargs="+", type=float, help="times of the field pictures [s] (default: four)")
    return whole


def _sets(arguments):
    return [part for override in arguments.set for part in ("--set", override)]


def _forwarded(arguments):
    return _sets(arguments) + (["--preset", arguments.preset] if arguments.preset else [])


def _run(arguments):
    if arguments.endpoint and not arguments.only:
        raise Error(BAD_INPUT, "--endpoint is for a single process; add --only fluid, structure or coupler.")
    if arguments.bind:
        if arguments.only != "coupler" or arguments.endpoint:
            raise Error(BAD_INPUT, "--bind is for --only coupler, in place of --endpoint; participants come with ./tern join.")
        arguments.endpoint = arguments.bind
    if (arguments.keys or arguments.insecure) and not arguments.only:
        raise Error(BAD_INPUT, "--keys and --insecure are for runs over a network; add --only coupler --bind tcp://HOST:PORT.")
    if arguments.only and not arguments.endpoint:
        raise Error(BAD_INPUT, "--only needs --endpoint: the address at which the three processes meet.")
    _check_ranks(arguments)
    arguments.case_options = _forwarded(arguments)
    arguments.network_options = ["--keys", arguments.keys] if arguments.keys else []
    arguments.network_options += ["--insecure"] if arguments.insecure else []
    request = run.Request(**{name: getattr(arguments, name) for name in run.Request.__dataclass_fields__ if hasattr(arguments, name)})
    if request.resume:
        case = cases.read(build.ensure(request.build), cases.find(request.case), request.case_options)
        request.resume = resumption.can_go_on(case["name"], request.out)
    return _answer(run.run(request))


def _check_ranks(arguments):
    """What needs another option that is not there."""
    for name, needed in (("oversubscribe", "ranks"), ("hosts", "ranks"), ("interface", "hosts"), ("ports", "hosts")):
        if getattr(arguments, name) and not getattr(arguments, needed):
            raise Error(BAD_INPUT, f"--{name} is for a fluid in many processes; add --{needed}.")


def _resume(arguments):
    if not (Path(arguments.run) / "run.json").exists():
        raise Error(BAD_INPUT, f"{arguments.run} holds no run: there is no run.json in it; name the results directory of one.")
    out = Path(arguments.run).resolve()
    request = run.resumed(out, arguments)
    contents, checkpoint = resumption.newest(out)
    if contents.get("status") == "done" and checkpoint and arguments.until is None and not _sets(arguments):
        run.tell(f"tern: {summary.shown(out)} has reached its end, t = {checkpoint['time_s']:.6g} s; --until T goes on beyond it.")
        return DONE
    request.case_options = request.case_options + _sets(arguments)
    request.retries = arguments.retries
    return _answer(run.run(request))


def _answer(ended):
    cause, out = ended
    if cause.exit_code in (INTERRUPTED, PEER_LOST, INPUT_OUTPUT) and (kept := resumption.manifests(out)):
        run.tell(f"tern: ./tern resume {summary.shown(out)} goes on from step {kept[0]['step']}, t = {kept[0]['time_s']:.6g} s")
    if cause.exit_code == NUMERICAL_FAILURE and (kept := resumption.manifests(out)):
        run.tell(f"tern: the state before it is kept: ./tern resume {summary.shown(out)} meets it again after step {kept[0]['step']}, "
                 f"t = {kept[0]['time_s']:.6g} s")
    if cause.exit_code != DONE:
        run.tell(f"tern: stopped: {cause.sentence} (exit code {cause.exit_code})")
    return cause.exit_code


def _join(arguments):
    arguments.only, arguments.bind, arguments.allow_unstable, arguments.record = arguments.role, None, False, False
    arguments.fluid = arguments.command if arguments.role == "fluid" else None
    arguments.structure = arguments.command if arguments.role == "structure" else None
    return _run(arguments)


def _keys(arguments):
    from tern.launch import keys
    keys.make(arguments.directory)
    return DONE


def _case_tool(arguments):
    path = cases.find(arguments.case)
    asked = [f"--{name}" for name in ("camera", "clip") if getattr(arguments, name, None)]
    picture = getattr(arguments, "picture", None)
    if asked and picture is None:
        raise Error(BAD_INPUT, f"{asked[0]} is for the picture of a case; add --picture.")
    if picture and Path(picture).suffix.lower() not in (".png", ".pdf", ".svg"):
        raise Error(BAD_INPUT, f"--picture {picture}: the name must end in .png, .pdf or .svg, which says what is written.")
    ranks, cluster = getattr(arguments, "ranks", None), _cluster(arguments)
    from tern.launch import calibration
    directory = build.ensure(arguments.build, ["tern-case"])
    costs = calibration.costs_file(directory)
    options = ["--costs", costs] if costs else []
    case = cases.read(directory, path, [*_forwarded(arguments), *options]) if ranks else None
    if case and not case["has_fluid"]:
        raise Error(BAD_INPUT, f"--ranks: the case {case['name']} has no fluid; it is the fluid that runs in many processes.")
    code = subprocess.run([directory / "tern-case", arguments.tool, path, *_forwarded(arguments), *options], check=False).returncode
    if code == DONE and arguments.tool == "explain":
        from tern.studies import advice
        if words := advice.text(cases.read(directory, path, _forwarded(arguments))):
            print("\n" + words)
        if ranks:
            print("\n" + scale_model.text(case["expected"], ranks, cluster))
    if code == DONE and picture is not None:
        print(f"picture: {_draw_case(arguments, directory, path, asked)}")
    return code


def _cluster(arguments):
    """The machines of a fluid in many processes, as they are asked for."""
    if getattr(arguments, "cluster", None) is None:
        return scale_model.Cluster(os.cpu_count() or 1)
    if not arguments.ranks:
        raise Error(BAD_INPUT, "--cluster is for a fluid in many processes; add --ranks.")
    return scale_model.read_cluster(arguments.cluster)


def _draw_case(arguments, directory, path, asked):
    """The picture of a case before its first step."""
    case = cases.read(directory, path, _forwarded(arguments))
    three = case["dimension"] == 3
    if asked and not three:
        raise Error(BAD_INPUT, f"{asked[0]} is for 3D cases; {case['name']} is none.")
    _ensure_pictures(*(packages.RENDER if three else []))
    from tern.plot import at_start, render, scenes
    start = cases.scene(directory, path, _forwarded(arguments), at_start.MOST_PARTICLES)
    look = scenes.Look(render.Camera(*(arguments.camera or [])), arguments.clip)
    return at_start.write(case, start, arguments.picture or Path("runs") / f"{case['name']}-start.png", look)


def _ensure_pictures(*more):
    """Installs what pictures and arrays need; the pictures of a command go to files."""
    packages.ensure([*packages.PICTURES, *more])
    os.environ["MPLBACKEND"] = "Agg"


def _verify(arguments):
    from tern.verify import command
    packages.ensure(packages.PICTURES)
    arguments.case_options = _forwarded(arguments)
    return command.verify(arguments)


def _study(arguments):
    _ensure_pictures()
    from tern.studies import command, documents
    if arguments.write_docs:
        return documents.write(arguments)
    if arguments.case is None:
        raise Error(BAD_INPUT, "study needs a CASE (or --write-docs).")
    if arguments.knobs:
        print("tern: --knobs is called --parameters now.", file=sys.stderr)
        arguments.parameters += arguments.knobs
    return command.study(arguments)


def _status(arguments):
    from tern.launch import status
    return status.status(arguments)


def _conform(arguments):
    from tern.launch import conform
    arguments.case_options = _forwarded(arguments)
    return conform.conform(arguments)


def _extremes(arguments):
    _ensure_pictures()
    from tern.extremes import command
    return command.extremes(arguments)


def _is_3d(directory):
    from tern.results import report
    return (Path(directory) / "run.json").exists() and report.read(Path(directory)).get("settings", {}).get("dimension") == 3


def _look(arguments):
    """How the 3D runs among `arguments.runs` are looked at; what draws them is installed when it is needed."""
    three = [_is_3d(name) for name in arguments.runs]
    asked = [f"--{name}" for name in ("camera", "clip", "slice") if getattr(arguments, name)]
    if asked and not all(three):
        raise Error(BAD_INPUT, f"{asked[0]} is for 3D runs; {arguments.runs[three.index(False)]} is none.")
    if arguments.slice and len(asked) > 1:
        raise Error(BAD_INPUT, f"--slice draws no scene, {asked[0]} is for one; leave one of them out.")
    _ensure_pictures(*(packages.RENDER if any(three) and not arguments.slice else []), *(packages.FILM if arguments.animate else []))
    from tern.plot import render, scenes
    return scenes.Look(render.Camera(*(arguments.camera or [])), arguments.clip, arguments.slice)


def _plot(arguments):
    if arguments.animate:
        return _animate(arguments)
    if arguments.fps or arguments.field:
        raise Error(BAD_INPUT, "--fps and --field are for a film; add --animate.")
    look = _look(arguments)
    from tern.plot import pictures
    for picture in pictures.plot(arguments.runs, arguments.times, look):
        print(picture)
    return DONE


def _animate(arguments):
    if arguments.times:
        raise Error(BAD_INPUT, "--times is for pictures; a film (--animate) takes all frames.")
    look = _look(arguments)
    from tern.plot import film
    for directory in arguments.runs:
        print(film.animate(directory, arguments.fps, arguments.field or "pressure", look), flush=True)
    return DONE


def _report(arguments):
    _ensure_pictures(*packages.REPORT, *(packages.RENDER if any(map(_is_3d, arguments.directories)) else []))
    from tern.report import write
    print(write.write_page(arguments.directories, arguments.out, arguments.times))
    return DONE


def _python(arguments):
    packages.ensure(packages.PYTHON)
    os.execv(sys.executable, [sys.executable, "-B", *arguments.words])


def _test(arguments):
    paths.source()
    packages.ensure(packages.BUILD + packages.PYTHON + packages.REPORT + packages.FILM + packages.RENDER + packages.TESTS
                    + sum(packages.PARTICIPANTS.values(), []))
    fuzz = arguments.label == "fuzz"
    if fuzz:
        packages.ensure(packages.FUZZ)
    directory = build.ensure("fuzz", build.FUZZERS) if fuzz else build.ensure(arguments.build, targets=None)
    ctest = ["ctest", "--test-dir", str(directory), "--output-on-failure", "--no-tests=error"]
    parallel = ["-j", str(len(os.sched_getaffinity(0)))]
    if arguments.label == "process":
        rounds = [[*ctest, "-L", "process"]]
    elif arguments.label:
        rounds = [[*ctest, *parallel, "-L", arguments.label]]
    else:
        # Whole processes are timed (a lost peer within 1 s), so they get the machine for themselves.
        rounds = [[*ctest, *parallel, "-LE", "process"], [*ctest, "-L", "process"]]
    failed = [command for command in rounds if subprocess.run(command, check=False).returncode != 0]
    return NUMERICAL_FAILURE if failed else DONE


def main(words):
    """Runs one command; returns the exit code."""
    if words[:1] == ["python"] and words[1:2] not in (["-h"], ["--help"]):
        arguments = argparse.Namespace(function=_python, words=words[1:])  # options and all, they are not ours
    else:
        arguments = parser().parse_args(words)
    try:
        return arguments.function(arguments)
    except Error as error:
        print(f"tern: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("tern: interrupted.", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        print(f"tern: {refusal(error)}.", file=sys.stderr)
        return INPUT_OUTPUT
