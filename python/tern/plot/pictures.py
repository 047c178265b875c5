"""./tern plot: pictures of runs, RUN/plots/*.png."""

from tern.plot import curves, fields, scenes, style
from tern.results.run import Run


def save(figure, run, name):
    return None if figure is None else style.save(figure, run, name)


def of_run(run, times, look=None):
    """All pictures of one run; returns their paths, None for what it has nothing to show of."""
    pictures = []
    chosen = fields.choose_times(run, times)
    digits = next(count for count in range(3, 18) if len({f"{time:.{count}f}" for time in chosen}) == len(chosen))
    for time in chosen:
        exact, figure = scenes.figure(run, time, look)
        pictures.append(style.save(figure, run, f"field_{exact:.{digits}f}s{scenes.name_of(look)}"))
    pictures += _save_pages(curves.gauges([run]), run, "gauges")
    for name, figure in (("energies", curves.energies(run)), ("steps", curves.steps(run))):
        pictures.append(save(figure, run, name))
    return pictures


def _save_pages(figures, run, name):
    return [style.save(figure, run, name if page == 1 else f"{name}-{page}") for page, figure in enumerate(figures, 1)]


def plot(directories, times, look=None):
    """Draws the runs in `directories`, field pictures at `times` [s] (None: four), of 3D runs as
    `look` (scenes.Look) says; returns the paths of the pictures."""
    style.apply()
    runs = [Run(directory) for directory in directories]
    pictures = [picture for run in runs for picture in of_run(run, times, look)]
    if len(runs) > 1:
        pictures += _save_pages(curves.gauges(runs), runs[0], "comparison")
    return [picture for picture in pictures if picture is not None]
