"""A film of a run from its frames, H.264 in MP4 through ffmpeg: one colour scale, one view, the time in the title."""

import os
import signal
import subprocess
import sys
import threading
import time as clock
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from tern.errors import UnreadableRun
from tern.plot import fields, scenes, style
from tern.results.run import Run

FEWEST_FRAMES = 5
USUAL_LENGTH = 8.0  # s, from 5 to 30 pictures a second


def _times(run):
    """The times of the frames, or why there are too few."""
    times = fields.times_of(run)
    if len(times) >= FEWEST_FRAMES:
        return times
    settings = run.settings
    interval = settings.get("output", {}).get("frame_interval")
    end = settings.get("end_time") or (times[-1] if times else 0) or 1.0
    told = "" if interval is None else f" (output.frame_interval = {interval:g} s)"
    raise UnreadableRun(
        f"{run.directory} holds {len(times)} frames{told}, a film needs at least {FEWEST_FRAMES}: run the case again with "
        f"--set output.frame_interval={end / 100:.2g}, which writes about 100.")


def _still_parts(run, times, field, cut):
    """What must not move from picture to picture: (colour ranges of both sides, view, what is enlarged).

    One pass over the frames, one frame in memory. A pressure that only a tenth of the frames reaches, an impact, does not
    set the scale for all the others.
    """
    of_fluid, of_structure = (values for _, _, values in fields.FIELDS[field])
    ranges, views, farthest = [], [], (0.0, None)
    for time in times:
        _, fluid, structure = fields.read(run, time)
        if field == "speed":
            fastest = max(np.percentile(values(side), 99.5) if side is not None and len(side["velocity"]) else 0.0
                          for values, side in ((of_fluid, fluid), (of_structure, structure)))
            ranges.append([(0.0, fastest), (0.0, fastest)])
        else:
            ranges.append(fields.limits_of(fluid, structure))
        views.append(fields.view_of(run, fluid, structure, cut))
        if fluid is not None and structure is not None:
            moved = fields.displacement(structure, run.frames_of("structure")[0]).max(initial=0.0)
            farthest = max(farthest, (float(moved), time), key=lambda one: one[0])
    ranges, views = np.array(ranges), np.array(views)
    lowest, highest = np.percentile(ranges[:, :, 0], 10, axis=0), np.percentile(ranges[:, :, 1], 90, axis=0)
    limits = [(float(low), max(float(high), float(low) + 1e-9)) for low, high in zip(lowest, highest)]
    view = [(float(low), float(high)) for low, high in zip(views[:, :, 0].min(axis=0), views[:, :, 1].max(axis=0))]
    shown = fields.focus(run, fields.read(run, farthest[1])[2], view) if farthest[1] is not None else None
    return limits, view, shown


def _stage(run, limits, field, shown):
    """(figure, its axes) with the colour bars in place: the axes are cleared for every picture, all else stays."""
    figure, axis, beside = fields.axes_of(shown, dpi=128)
    figure.set_size_inches(10, 6.5)
    _, fluid, structure = fields.read(run, 0.0)
    mappables = [side and ScalarMappable(Normalize(*range_), colours) for side, range_, (_, colours, _) in
                 zip((fluid, structure), limits, fields.FIELDS[field])]
    bars = sum(mappable is not None for mappable in mappables) if field != "speed" else 1
    figure.subplots_adjust(left=0.07, right=0.99 if bars == 1 else 0.96, bottom=0.09, top=0.9)
    fields.colour_bars(figure, [axis, beside] if beside else axis, mappables, field, shrink=0.75)
    return figure, axis, beside


def _encoder(path, figure, rate):
    """ffmpeg reading raw pictures from its standard input; in a session of its own, so that Ctrl-C is ours to answer."""
    width, height = figure.canvas.get_width_height()
    return subprocess.Popen(
        ["ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}", "-r", f"{rate:g}",
         "-i", "-", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-c:v", "libx264", "-crf", "23", "-pix_fmt", "yuv420p",
         "-movflags", "+faststart", "-f", "mp4", str(path)],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)


def _progress(done, total, began):
    if sys.stderr.isatty() or done == total:
        left = (clock.monotonic() - began) * (total - done) / done
        print(f"\rfilm: picture {done} of {total}, {left:.0f} s to go ", end="\n" if done == total else "", file=sys.stderr, flush=True)


def _flat(run, times, field, cut):
    """(figure, what draws the frame at a time into it) of a 2D run or of a slice."""
    limits, view, shown = _still_parts(run, times, field, cut)
    figure, axis, beside = _stage(run, limits, field, shown)

    def draw(time):
        exact, fluid, structure = fields.read(run, time)
        for axes in filter(None, (axis, beside)):
            axes.clear()
        fields.panel(axis, run, fluid, structure, limits, field, view, cut, shown, beside)
        fields.title(axis, run, exact, cut)
    return figure, draw


def _rendered(run, times, field, look):
    """The same of a 3D run: one camera and one scale for all frames."""
    boxes, ranges = [], []
    for time in times:
        _, fluid, structure = fields.read(run, time)
        boxes.append(scenes.box_of(run, fluid, structure))
        fastest = [np.percentile(np.linalg.norm(side["velocity"], axis=1), 99.5) for side in (fluid, structure)
                   if side is not None and len(side["velocity"])]
        ranges.append(scenes.limits_of(fluid, structure) if field == "pressure" else 2 * [(0.0, max([*fastest, 1e-9]))])
    box = np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)
    if look.clip:
        scenes.check(run, look.clip, box, "--clip")
    ranges = np.array(ranges)
    limits = list(zip(np.percentile(ranges[:, :, 0], 10, axis=0), np.percentile(ranges[:, :, 1], 90, axis=0)))
    figure, axis, changing = scenes.stage(run, *fields.read(run, times[0])[1:], limits, field, box, look, dpi=128, layout="constrained")
    fields.title(axis, run, times[-1], None)
    figure.canvas.draw()  # lays out the first picture, and with it all
    figure.set_layout_engine("none")

    def draw(time):
        exact, fluid, structure = fields.read(run, time)
        scenes.change(axis, changing, run, fluid, structure, limits, field, box, look)
        fields.title(axis, run, exact, None)
    return figure, draw


def animate(directory, rate=None, field="pressure", look=None):
    """Writes RUN/film.mp4, whole or not at all; returns its path. The name also says another field than pressure, and another look.

    `rate`: pictures per second; default: the film lasts about 8 s. `look` (scenes.Look): how a 3D run is looked at.
    """
    style.apply()
    run = Run(directory)
    times = _times(run)
    look = look or scenes.Look()
    if scenes.is_rendered(run, look):
        figure, draw = _rendered(run, times, field, look)
    else:
        if look.slice:
            scenes.check(run, look.slice, scenes.box_of(run, *fields.read(run, times[0])[1:]), "--slice")
        figure, draw = _flat(run, times, field, fields.Cut(*look.slice) if look.slice else None)
    path = Path(directory) / f"film{'' if field == 'pressure' else '_' + field}{scenes.name_of(look)}.mp4"
    unfinished = path.with_name(path.name + ".part")
    encoder = _encoder(unfinished, figure, rate or min(max(len(times) / USUAL_LENGTH, 5), 30))
    began = clock.monotonic()
    interrupted = []
    here = threading.current_thread() is threading.main_thread()  # the only one in which Python lets a handler be set
    # A flag, since an exception within a callback of matplotlib would be dropped and the film go on.
    handler = signal.signal(signal.SIGINT, lambda *_: interrupted.append(True)) if here else None
    try:
        for number, time in enumerate(times, 1):
            if interrupted:
                raise KeyboardInterrupt
            draw(time)
            figure.canvas.draw()
            encoder.stdin.write(figure.canvas.buffer_rgba())
            _progress(number, len(times), began)
        encoder.stdin.close()
        complaint = encoder.stderr.read().decode(errors="replace").strip()
        if interrupted:
            raise KeyboardInterrupt
        if encoder.wait() != 0:
            raise OSError(f"{path} could not be written: ffmpeg says: {complaint}")
        os.replace(unfinished, path)
    except BrokenPipeError:
        if interrupted:  # ffmpeg got it as well
            raise KeyboardInterrupt from None
        raise OSError(f"{path} could not be written: ffmpeg says: {encoder.stderr.read().decode(errors='replace').strip()}") from None
    finally:
        if here:
            signal.signal(signal.SIGINT, handler)
        plt.close(figure)
        if encoder.poll() is None:
            encoder.kill()
            encoder.wait()
        unfinished.unlink(missing_ok=True)
    return path
