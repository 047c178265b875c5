"""interface.record of a run (./tern run CASE --record): the messages of one side, to be played back in another run."""

from pathlib import Path

from tern.participant.schema import wire
from tern.participant.side import bad_input, run_participant
from tern.results import report, series

# What the motion of a side depends on; the rest of the case may differ from that of the record.
_OWN_TABLES = {"fluid": ("dimension", "gravity", "domain", "wall", "fluid", "gauge"),
               "structure": ("dimension", "gravity", "structure", "gauge")}
_SAME_TIME = 1e-8  # relative; steps.csv has nine digits


def messages(path):
    """All whole messages of a record; the last of a run that was killed may be cut short and is left out."""
    with open(path, "rb") as file:
        while True:
            size, shift = 0, 0
            while (byte := file.read(1)) and byte[0] & 0x80:
                size, shift = size | (byte[0] & 0x7F) << shift, shift + 7
            if not byte:
                return
            size |= byte[0] << shift
            content = file.read(size)
            if len(content) < size:
                return
            yield wire.Message.FromString(content)


def _flat(value, name):
    """{dotted key: value} of nested tables and lists."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if pairs is None:
        return {name: value}
    return {key: inner for part, content in pairs for key, inner in _flat(content, f"{name}.{part}").items()}


class Recording:
    """The messages of this side of a run in the directory `directory`, one after the other."""

    def __init__(self, directory, run):
        self._run, self._path = run, Path(directory) / "interface.record"
        if not self._path.is_file():
            raise bad_input(f"{directory} has no interface.record; make one with ./tern run CASE --record.")
        self._refuse_another_case(Path(directory))
        self._ends = [end for end, _ in series.read(Path(directory) / "steps.csv", "t_s")]
        sender = {"fluid": wire.FLUID, "structure": wire.STRUCTURE}[run.role]
        self._messages = (message for message in messages(self._path) if message.sender == sender)
        self._next = next(self._messages, None)
        self.hello = self.take("hello")
        self.hello.case_hash = run.case.hash

    def _refuse_another_case(self, directory):
        recorded = report.read(directory)["settings"]
        for table in _OWN_TABLES[self._run.role]:
            old, new = (_flat(settings.get(table, {}), table) for settings in (recorded, self._run.case.settings))
            for key in {**old, **new}:
                if old.get(key) != new.get(key):
                    raise bad_input(f"{self._path} was made with {key} = {old.get(key)}, and this case has {new.get(key)}: the "
                                    f"{self._run.role} would have moved in another way.")

    def check_window(self, window):
        """The messages belong to the windows they were made in."""
        step, end = self._run.channel.step, (window.begin_ticks + window.duration_ticks) / 2.0**32
        if step > len(self._ends):
            self._at_end()
        if abs(end - self._ends[step - 1]) > _SAME_TIME * end:
            raise bad_input(f"Window {step} ends at t = {end:.9g} s, in {self._path} at {self._ends[step - 1]:.9g} s: a record can be "
                            "played back only in the windows it was made in. They follow from the proposals of the fluid, the frame "
                            "interval and the end of the run.")

    def is_next(self, kind):
        return self._next is not None and self._next.WhichOneof("body") == kind

    def peek(self, kind):
        return getattr(self._next, kind)

    def take(self, kind):
        """The body of the next message, which has to be of this kind."""
        if not self.is_next(kind):
            self._at_end()
        body = getattr(self._next, kind)
        self._next = next(self._messages, None)
        return body

    def take_or(self, kind, otherwise):
        """The body of the next message if it is of this kind, else `otherwise`."""
        return self.take(kind) if self.is_next(kind) else otherwise

    def pass_over(self, kind):
        """Leaves out what is next of this kind."""
        while self.is_next(kind):
            self.take(kind)

    def _at_end(self):
        raise bad_input(f"{self._path} ends with window {self._run.report.steps}; end this run there, with --until "
                        f"{self._run.report.time_s:.9g}, or make a longer record.")


def play_back(role, answer):
    """Takes part as `role`, fluid or structure; the record is that of the run named by --from. Returns the exit code.

    answer(run, record, account) sends what the record holds for one window, and returns the account of energy at its end; `account` is
    the one before.
    """

    def obey(run):
        record = Recording(run.options.record, run)
        account = record.hello.account
        run.handshake(record.hello)
        while (order := run.receive("begin_window", "finish")).WhichOneof("body") == "begin_window":
            record.check_window(order.begin_window)
            account = answer(run, record, account)
            run.step_done(order)
        run.finish(order, account)

    return run_participant(role, obey, lambda parser: parser.add_argument(
        "--from", dest="record", metavar="RUN", required=True, help="directory of a run with --record"))
