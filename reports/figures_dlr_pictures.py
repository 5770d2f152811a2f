"""Figures of the study of real pictures: what was found, and how errors grow with distance."""

from __future__ import annotations

from pathlib import Path

from reports import dlr_pictures, style
from reports.errors import ReportError
from reports.run import Run


def draw_sheet(run: Run, name: str) -> Path:
    """Six pictures with detections and annotated rows; the data are the counts of all pictures."""
    from matplotlib.image import imread

    path = run.folder / "figures" / f"dlr-pictures--{name}.png"
    try:
        picture = imread(path)
    except (OSError, ValueError) as error:
        raise ReportError(f"{path} is missing or damaged: run the study again") from error
    data = dlr_pictures.pictures(run)
    with style.styled():
        figure = style.new_figure(9.6, 9.6 * picture.shape[0] / picture.shape[1])
        panel = figure.subplots()
        panel.imshow(picture)
        panel.set_axis_off()
        return style.save(figure, data[data["filter"] == name], run.folder, f"dlr-found--{name}")


def draw_errors(run: Run, name: str) -> Path:
    """Median, quartiles, 5th and 95th percentile of distance and bearing error over distance."""
    data = dlr_pictures.error_by_range(run, name)
    with style.styled():
        figure = style.new_figure(9.6, 3.2)
        for panel, (what, unit) in zip(
            figure.subplots(1, 2), (("range", "m"), ("bearing", "deg")), strict=True
        ):
            percent = [data[f"{what}_error_p{p}_{unit}"] for p in (5, 25, 50, 75, 95)]
            colour = style.SERIES[0]
            panel.fill_between(data["range_m"], percent[0], percent[4], color=colour, alpha=0.2, linewidth=0)
            panel.fill_between(data["range_m"], percent[1], percent[3], color=colour, alpha=0.4, linewidth=0)
            panel.plot(data["range_m"], percent[2], color=colour, linewidth=1.5)
            panel.set(xlabel="distance of the disc, m", ylabel=f"error of {what}, {unit}")
            panel.grid(axis="y")
        return style.save(figure, data, run.folder, f"dlr-errors--{name}")
