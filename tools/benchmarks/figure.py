"""The work-precision diagram: error against CPU time, both on logarithmic scales."""

from __future__ import annotations

import io

from benchmarks.section import Section

STYLES = (
    ("o", "#0b6e4f"),
    ("s", "#1f6feb"),
    ("^", "#b35900"),
    ("D", "#a11d33"),
    ("v", "#6f42c1"),
    ("P", "#57606a"),
    ("X", "#c2255c"),
)


def draw(section: Section) -> bytes:
    """The diagram as SVG."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams.update({"svg.hashsalt": "cutjoint", "font.size": 10})
    figure, axes = pyplot.subplots(figsize=(7.0, 4.4))
    for (engine, points), (marker, colour) in zip(section.points.items(), STYLES, strict=False):
        ordered = sorted(points)
        times, errors = [1e3 * time for time, _ in ordered], [error for _, error in ordered]
        axes.loglog(times, errors, marker=marker, color=colour, label=engine, linewidth=1.4, markersize=5)
    axes.set_xlabel("CPU time of the run [ms]")
    axes.set_ylabel("largest tool error [m]")
    axes.set_title(section.title.split(":")[0] + ": left and low is good")
    axes.grid(visible=True, which="major", color="#dddddd")
    axes.legend(frameon=False, fontsize=9)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    figure.tight_layout()
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    pyplot.close(figure)
    return buffer.getvalue()
